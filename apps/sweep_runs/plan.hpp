#pragma once
// The cases of a sweep of runs: seeds, settings, parameters, faults and robot files, made from their number one by one.
#include <cstdint>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "apps/command/json.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {

/// As the command line has them.
struct SweepAxes {
  std::vector<std::string> robots;  // robot files
  std::string seeds;                // "1..1000", "3,5,7", "1..10,20"; empty: the robot file's
  std::vector<std::string> set;     // "MODULE.PARAM=A,B", "MODULE.PARAM=FROM:TO:COUNT[:log]", one axis each
  std::vector<std::string> faults;  // each is an alternative: "none", "imu:off@5", "imu:off@5&range:stuck@6"
  std::vector<std::string> params;  // files; "none": the robot file's
  std::string list;                 // a file with the options of one run a line, in place of the three above
  std::string camera;               // of all runs, and so are the rest
  double duration_s = 0;
  std::vector<std::string> plant_args;
};

/// Which seeds: ranges, in the order in which they were given.
class SeedRange {
 public:
  /// Errors:  nothing, with `why`.
  static std::optional<SeedRange> parse(const std::string& text, std::string& why);
  std::uint64_t count() const { return count_; }
  std::uint64_t at(std::uint64_t index) const;

 private:
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges_;  // first and how many
  std::uint64_t count_ = 0;
};

/// The lines of a list without those that are empty or begin with "#". Only every kEach-th place is in memory.
/// Thread:  owner.
class RunList {
 public:
  /// Reads all lines once, and tells each one's words. Errors: false, with `why` (FILE:LINE).
  using Each = std::function<bool(std::vector<std::string> words, std::string& why)>;
  bool open(const std::string& path, const Each& each, std::string& why);
  std::uint64_t count() const { return count_; }
  std::vector<std::string> words(std::uint64_t index);

 private:
  static constexpr std::uint64_t kEach = 256;
  bool next(std::string& line);  // the next line that counts

  std::string path_;
  std::ifstream in_;
  std::vector<std::uint64_t> places_;
  std::uint64_t count_ = 0, at_ = 0, line_ = 0;
};

/// All combinations. The seed changes most slowly, so that a sweep that is ended early has as many runs of each kind.
/// Thread:  owner.
class SweepPlan {
 public:
  /// Checks every value of every axis as `sinew run` would, before anything flies; prints what is wrong on standard
  /// error. Null: something is.
  static std::unique_ptr<SweepPlan> make(const SweepAxes& axes, const rt::ModuleTypes& types);

  std::uint64_t cases() const { return seeds_.count() * variants_; }
  /// The words for `sinew run` of a case; "--virtual" and what concerns output is not among them.
  std::vector<std::string> words(std::uint64_t number);
  /// All that decides the cases: axes as they were given, and hashes of the contents of files and programs.
  Json identity() const;
  /// Every file that the options name, and those that these name: what a robot extends, its calibration.
  const std::set<std::string>& files() const { return files_; }
  /// The options that decide the cases, for `sinew sweep`.
  std::vector<std::string> options() const;
  const std::string& robot_name() const { return robot_; }    // of the first robot file
  const std::string& runs_folder() const { return folder_; }  // where it records

 private:
  struct Axis {
    std::vector<std::vector<std::string>> values;  // words of each
  };
  bool prepare_robots(const rt::ModuleTypes& types);
  bool add_set_axes(const rt::ModuleTypes& types);
  bool add_fault_axis(const rt::ModuleTypes& types);
  bool add_params_axis(const rt::ModuleTypes& types);
  bool open_list(const rt::ModuleTypes& types);
  bool hash_programs();

  SweepAxes asked_;
  SeedRange seeds_;
  bool seeded_ = false;
  std::vector<Axis> axes_;
  RunList list_;
  std::uint64_t variants_ = 1;
  std::string robot_, folder_;
  Json contents_ = Json::object();  // hashes of files, by name
  std::set<std::string> files_;
};

}  // namespace sinew::app
