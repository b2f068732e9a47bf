#pragma once
// Two sweeps run by run: what got better, what got worse, and whether chance alone explains it.
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "apps/sweep/case_result.hpp"
#include "apps/sweep/statistics.hpp"
#include "hal/file.hpp"

namespace sinew::sweep {

/// Holds 32 bytes for each result of the earlier sweep. Thread: owner.
class Comparison {
 public:
  static constexpr std::size_t kMostListed = 20;
  /// Reads the earlier results. Null, with `why`: it is no such file.
  static std::unique_ptr<Comparison> open(const std::string& path, std::string& why);

  /// A result of now; each once. Runs are pairs when their options are equal; where the first one has no equal, runs
  /// with the same seed are. False, with `why`: seeds make no pairs, since several runs have the same.
  bool add(const CaseResult& now, std::string& why);

  std::uint64_t pairs() const { return both_good_ + both_bad_ + better_ + worse_; }
  std::string text() const;
  app::Json json() const;

 private:
  struct Earlier {
    std::uint64_t run = 0, seed = 0;  // hashes
    std::uint64_t begin = 0;          // of its line
    std::uint32_t bytes = 0;
  };
  struct Change {
    Quantiles before{}, now{}, difference{};  // now less before
    std::uint64_t smaller = 0, larger = 0;
  };
  enum class By { not_known, run, seed };

  Comparison(std::string path, std::unique_ptr<hal::InputFile> file) : path_(std::move(path)), file_(std::move(file)) {}
  bool choose(const CaseResult& first, std::string& why);
  const Earlier* find(std::uint64_t key) const;
  std::uint64_t key_of(const Earlier& earlier) const { return by_ == By::run ? earlier.run : earlier.seed; }
  void compare(const CaseResult& before, const CaseResult& now);

  std::string path_;
  std::unique_ptr<hal::InputFile> file_;
  std::vector<Earlier> earlier_;  // by key_of()
  std::vector<bool> taken_;
  By by_ = By::not_known;
  std::uint64_t both_good_ = 0, both_bad_ = 0, better_ = 0, worse_ = 0, alone_ = 0;
  std::vector<std::string> got_better_, got_worse_;  // the first of them: what was, what is, and the command
  std::vector<std::string> order_;
  std::map<std::string, Change> changes_;
};

}  // namespace sinew::sweep
