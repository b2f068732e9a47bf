// sinew-locate: how well soccer::Locate does, on walks without pictures and on recorded runs. docs/soccer-world.md.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>

#include "apps/bag/bag_file.hpp"
#include "apps/locate/recorded.hpp"

namespace {

using namespace sinew;
using namespace sinew::locate;

constexpr int kOk = 0, kNotBegun = 2;

int fail(const std::string& what) {
  std::fprintf(stderr, "sinew-locate: %s\n", what.c_str());
  return kNotBegun;
}

/// "found within 10 s: 96 of 100; median 1.6 s"
void say_times(const char* what, std::vector<double> times, double within_s) {
  std::ranges::sort(times);
  const auto in_time = std::ranges::upper_bound(times, within_s) - times.begin();
  std::printf("  %s within %.0f s: %td of %zu; median %.1f s\n", what, within_s, in_time, times.size(),
              times.empty() ? 0 : times[times.size() / 2]);
}

int run_study(const StudyOptions& o) {
  std::printf("walks of %.0f s, %llu of them\n  %s\n", o.seconds, static_cast<unsigned long long>(o.runs),
              text(study_walks(o)).c_str());
  for (const bool reentry : {false, true}) {
    const Kidnappings k = study_kidnappings(o, reentry);
    std::printf(reentry ? "put back over the touch line after a penalty\n"
                        : "carried anywhere and told nothing; a mate's ball from 10 s on\n");
    say_times("found, up to half a turn,", k.found_s, 10);
    say_times("in the right half", k.right_half_s, 20);
  }
  return kOk;
}

int run_judge(const std::vector<std::string>& files, const std::string& topic, double settle_s,
              const std::string& svg) {
  app::Progress progress("judge", files.size() > 1, app::ProgressOf::parts);
  PoseErrors all;
  std::vector<std::vector<RecordedPlace>> runs;
  for (const std::string& file : app::each_file_once(files)) {
    const auto reader = app::open_recording(file, progress);
    if (!reader) return kNotBegun;
    std::string why;
    auto places = read_places(*reader, topic, why);
    if (!places) return fail(file + ": " + why);
    const PoseErrors e = errors_of(*places, settle_s);
    std::printf("%s\n  %s\n", file.c_str(), text(e).c_str());
    all.add(e);
    runs.push_back(std::move(*places));
  }
  if (runs.size() > 1) std::printf("all\n  %s\n", text(all).c_str());
  if (svg.empty()) return kOk;
  std::ofstream out(svg);
  out << draw_paths(soccer::Field(), runs);
  return out.flush() ? kOk : fail(svg + ": cannot be written");
}

}  // namespace

int main(int argc, char** argv) {
  StudyOptions o;
  std::vector<std::string> files;
  std::string topic = "locate.nav", svg;
  CLI::App app("How well a robot knows where it is on the field: docs/soccer-world.md");
  app.require_subcommand(1);
  CLI::App* const study =
      app.add_subcommand("study", "Walks and kidnappings without pictures, with the errors that vision has");
  study->add_option("--runs", o.runs, "of each kind")->check(CLI::Range(1, 1000000));
  study->add_option("--first-seed", o.first_seed);
  study->add_option("--seconds", o.seconds, "of a walk")->check(CLI::Range(15.0, 36000.0));
  CLI::App* const judge = app.add_subcommand("judge", "Recorded runs against the simulator's truth");
  judge->add_option("files", files, "run.mcap")->required()->check(CLI::ExistingFile);
  judge->add_option("--topic", topic, "NavState in the world's frame [locate.nav]");
  judge->add_option("--settle", o.settle_s, "seconds at the begin that do not count [10]")->check(CLI::Range(0.0, 1e6));
  judge->add_option("--svg", svg, "draws the field with true and believed paths");
  CLI11_PARSE(app, argc, argv);
  return study->parsed() ? run_study(o) : run_judge(files, topic, o.settle_s, svg);
}
