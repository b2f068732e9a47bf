#pragma once
// The commands on recorded files, each with its options.
#include "apps/bag/bag_file.hpp"
#include "apps/bag/plot_output.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {

struct BagOptions {
  std::string file;
  bool json = false;
};
struct BagInfoOptions : BagOptions {
  std::vector<std::string> files{};  // instead of `file`
};
struct BagCopyOptions : BagOptions {
  std::string out;
  std::vector<std::string> files{};  // merge: instead of `file`
  bool ros2 = false;                 // convert: to messages of ROS 2
  Selection what{};
};
struct BagCatOptions : BagOptions {
  Selection what{};
  bool names = false;  // in place of numbers
};
struct BagTopicOptions : BagOptions {
  std::string out;  // csv: empty: standard output
  Selection what{};
  bool names = false;  // csv: in columns of their own
};

struct BagPlotOptions : BagOptions {
  PlotOptions plot{};
  std::optional<double> from_s{}, until_s{};
};

struct BagPlayOptions : BagOptions {
  Selection what{};
  std::string name;  // of the robot on this machine; empty: the recorded robot's name
  double rate = 1;
  bool loop = false;
  bool paused = false;                     // nothing is played at first
  bool stay = false;                       // after the end of the file, too
  const rt::ModuleTypes* types = nullptr;  // what is known of the recorded robot's modules
};

/// `file` is the first flight.
struct BagCompareOptions : BagOptions {
  std::string other;                  // the second flight
  std::string from_event;             // where both times begin; empty: the start of the climb, or arming, or the start
  std::vector<std::string> fields{};  // record::means(); none: the usual ones
  std::string plot;                   // a new file; empty: none
};

int bag_info(const BagInfoOptions& options);
int bag_check(const BagOptions& options);
int bag_recover(const BagCopyOptions& options);
int bag_cut(const BagCopyOptions& options);
int bag_filter(const BagCopyOptions& options);
int bag_merge(const BagCopyOptions& options);
int bag_convert(const BagCopyOptions& options);
int bag_play(const BagPlayOptions& options);
int bag_cat(const BagCatOptions& options);
int bag_csv(const BagTopicOptions& options);
int bag_plot(const BagPlotOptions& options);
int bag_images(const BagTopicOptions& options);
int bag_compare(const BagCompareOptions& options);

}  // namespace sinew::app
