#pragma once
// Many runs of robot files, each in a process of its own, with their results in one file.
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "apps/sweep/process_pool.hpp"
#include "apps/sweep/results_file.hpp"
#include "apps/sweep_runs/plan.hpp"
#include "apps/sweep_runs/run_result.hpp"
#include "apps/sweep_runs/sweep_report.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {

struct SweepOptions {
  SweepAxes axes{};
  unsigned jobs = 0;        // at a time; 0: one for each processor
  double patience_s = 300;  // of real time, for one run
  std::string results;      // file; empty: one beside the recordings, for this sweep alone
  std::string shard;        // "2/5"; empty: all
  double until_width = 0;   // stop when the interval of the good share is as narrow; 0: not before the end
  bool record_failures = false;
  std::string in;  // folder that names of robot files, parameters and the list are relative to; empty: the current one
  std::string pack;  // folder that is made for other machines, in place of flying; empty: none
  ReportOptions report{};
};

/// Thread:  owner; the only one of the process.
class SweepRun {
 public:
  SweepRun(const SweepOptions& options, const rt::ModuleTypes& types) : options_(options), types_(types) {}
  /// Exit code: 0: all runs were good; 1: some were not, or not all were made; 2: it could not begin.
  int run();

 private:
  int pack();
  bool open();
  bool read_earlier();
  bool fly();
  void note(std::uint64_t number, bool good);  // a case that the file has
  bool record_failures();
  bool read_failures(std::map<std::uint64_t, std::uint64_t>& prints) const;
  int tell();
  std::vector<std::string> argv_of(const std::vector<std::string>& words) const;

  const SweepOptions& options_;
  const rt::ModuleTypes& types_;
  std::unique_ptr<SweepPlan> plan_;
  sweep::Identity identity_;
  sweep::Shard shard_;
  std::string path_;
  std::unique_ptr<sweep::ResultsFile> file_;
  std::vector<bool> good_;                      // by case, of those that the file has
  std::uint64_t prefix_ = 0, prefix_good_ = 0;  // cases from 0 on without a gap
  bool narrow_ = false;                         // the interval of the prefix is narrow enough
  std::uint64_t flown_ = 0;
  double wall_s_ = 0;
  bool interrupted_ = false, failed_ = false;
  std::vector<std::string> recorded_;  // what is told of the recordings
};

}  // namespace sinew::app
