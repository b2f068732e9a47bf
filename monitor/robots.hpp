#pragma once
#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "monitor/robot_link.hpp"

namespace sinew::monitor {

/// The robots of this machine and user, as they come and go.
/// Thread:  any.
class Robots {
 public:
  Robots();
  ~Robots();
  Robots(const Robots&) = delete;
  Robots& operator=(const Robots&) = delete;

  /// In order of name.
  std::vector<std::shared_ptr<RobotLink>> all() const;
  /// Null: none of this name runs.
  std::shared_ptr<RobotLink> find(const std::string& robot) const;
  /// Why the run folder cannot be read; empty: it can.
  std::string problem() const;
  /// Looks once, now.
  void look();

  static constexpr std::chrono::milliseconds kPeriod{250};  // between two looks at the run folder

 private:
  mutable std::mutex mutex_;  // of the next three
  std::condition_variable stopped_;
  std::map<std::string, std::shared_ptr<RobotLink>> links_;
  std::string problem_;
  bool stop_ = false;
  std::mutex looking_;
  std::thread thread_;
};

}  // namespace sinew::monitor
