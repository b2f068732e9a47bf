#pragma once
#include <memory>
#include <string>
#include <vector>

#include "hal/linux/process.hpp"
#include "hal/stream.hpp"

namespace sinew::app {

struct PlantRequest {
  std::string endpoint;        // "auto": start sinew-sim; else where a plant listens
  std::string world = "quad";  // of one that is started
  std::uint64_t seed = 1;
  std::uint32_t camera_width = 320, camera_height = 240;
  bool lockstep = true;
  std::vector<std::string> extra;  // arguments for sinew-sim
};

/// A plant to talk to: one of its own (started here, ended with this object), or one that listens already.
/// Thread:  owner.
class PlantProcess {
 public:
  /// Errors:  in `why`: sinew-sim is not built, ended at once (with its own words), nobody listens.
  static std::unique_ptr<PlantProcess> open(const PlantRequest& request, std::string& why);
  ~PlantProcess();

  std::unique_ptr<hal::Stream> take_stream() { return std::move(stream_); }
  /// Where it listens: for further connections.
  const std::string& endpoint() const { return endpoint_; }
  /// Of the plant that was started here; 0: the plant is foreign, and its processor time is not known.
  int pid() const { return child_ ? child_->pid() : 0; }
  /// After a failure: `why`; for a plant of our own that has ended, also how it ended and its last words.
  std::string with_its_end(std::string why);
  /// Waits for a plant of our own to end by itself.
  void wait_for_end();
  /// In a runtime beside its parent: the parent ends the plant.
  void leave_to_parent();
  /// In the parent: the connection belongs to the runtime.
  void leave_to_runtime() { stream_.reset(); }

 private:
  PlantProcess() = default;
  bool start(const PlantRequest& request, std::string& why);
  std::string end() const;

  std::unique_ptr<hal::ChildProcess> child_;
  std::unique_ptr<hal::Stream> stream_;
  std::string endpoint_, socket_path_, log_path_;
};

}  // namespace sinew::app
