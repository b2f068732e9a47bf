#pragma once
// What a recording says about its run besides the robot file: what was asked for, the world, and how it ended.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "record/run/run_sink.hpp"

namespace sinew::app {

struct Prepared;
struct RunOptions;

/// Metadata at the beginning, each only where there is something to say. Those of lists have numbers as keys.
/// Source:  docs/recording.md
inline constexpr std::string_view kOptionsName = "sinew.options",  // list: "--set sim.gust_mps=3", "--seed 7"
    kWorldName = "sinew.world",                                    // of a run with a plant: plant, world, seed, wind
    kPlantArgumentsName = "sinew.plant_arguments",                 // list, as --plant-arg gave them
    kFaultsName = "sinew.faults",                                  // list, as --fault gave them
    kPoliciesName = "sinew.policies";                              // module: hash and path of its network
inline constexpr std::string_view kReportFile = "report.json";     // attachment: the plant's last report
std::vector<record::Metadata> run_metadata(const Prepared& prepared, const RunOptions& options);

/// How a run ended, or a recording of it.
struct RunResult {
  static constexpr const char *kEndFailed = "failed",  // before there was anything to judge
      *kEndRecordingStopped = "the recording was stopped, the run went on";
  std::string end{};                // one of these, or RunSummary::Result::end
  std::string outcome{}, why{};     // empty: nothing to say
  std::optional<int> exit_code{};   // of `sinew run`
  std::string timing{};             // why the run is no measurement of timing; empty: it is, or nothing judges it
  std::optional<double> ended_s{};  // since the first cycle, by the robot's clock
};
/// `report`: the plant's, JSON; empty: none. `at`: of the attachment, in the file's time.
record::RunEnd end_of_run(const RunResult& result, const std::string& report, std::uint64_t at);

}  // namespace sinew::app
