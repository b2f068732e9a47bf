#pragma once
// The robots of one machine by name: which run, and where their sockets are.
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hal/linux/run_dir.hpp"
#include "hal/result.hpp"

namespace sinew::tap {

/// A robot's name, held by this process from before its devices are opened until it ends. Two robots of one name would
/// steer the same motors; two of different names never meet. A killed robot's name is taken over.
/// Thread:  owner.
class Name {
 public:
  /// Errors:  bad_argument (names are A-Z a-z 0-9 _ - up to 40 characters); busy: it runs already (detail: its process
  ///          id); denied, io. `why` has the error in words.
  static hal::Result<std::unique_ptr<Name>> take(std::string_view robot, std::string& why);
  const std::string& robot() const { return robot_; }
  /// Path of the socket, for hal::listen_stream().
  const std::string& path() const { return path_; }

 private:
  Name(std::string robot, std::string path, std::unique_ptr<hal::FileLock> lock)
      : robot_(std::move(robot)), path_(std::move(path)), lock_(std::move(lock)) {}
  std::string robot_, path_;
  std::unique_ptr<hal::FileLock> lock_;
};

struct Running {
  std::string robot;
  int pid = 0;
  std::string path;  // of its socket
};

/// The robots of this user that run now, in order of name; without robots that were killed.
/// Errors:  what hal::run_dir() says, in words in `why`.
hal::Result<std::vector<Running>> running(std::string& why);

/// The robot of this name, or, when `robot` is empty, the only one that runs.
/// Errors:  not_found: none of this name, or none at all; bad_argument: several run, name one. `why` lists them.
hal::Result<Running> find_running(std::string_view robot, std::string& why);

}  // namespace sinew::tap
