#pragma once
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::plant {

/// What `sinew-sim --redraw` was asked for.
struct RedrawOptions {
  std::string file;                                          // of --scenes; empty: nothing is drawn again
  std::string of;                                            // a robot, whose pictures go to standard output
  std::string mcap;                                          // file for them, in place of standard output
  std::vector<double> window_s;                              // from, until: only those of this time
  std::vector<double> at_s;                                  // or pictures from outside at these times
  std::string folder;                                        // of those
  std::vector<double> eye_m{0, -7.5, 5}, target_m{0, 0, 0};  // for those

  /// It is an option of --redraw.
  static bool has(std::string_view option) {
    static const std::set<std::string_view> kOwn{"--redraw", "--of",     "--at",     "--png",
                                                 "--eye",    "--target", "--window", "--mcap"};
    return kOwn.contains(option);
  }
};

/// Draws pictures of a run again from the file of its scenes (SceneRecord): all of a robot's cameras, to standard
/// output or to a file (MCAP, topics are the devices' names, times are the world's) in the order of their time, with
/// the same noise and so the same bytes as in the run; or PNG files from outside, `at-SECONDS.png`, each of the last
/// scene that is not later. Exit code 0: drawn; 1: not, as was said on standard error.
int redraw(const RedrawOptions& options);

}  // namespace sinew::plant
