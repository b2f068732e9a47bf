#pragma once
// A temporary folder that ends with its process, however the process ends.
#include <memory>
#include <string>

#include "hal/linux/run_dir.hpp"

namespace sinew::hal {

/// A new folder in the temporary folder, for its owner only, which goes with this object. The folder of a process that
/// was killed is removed by the next make() with the same `begin`: a lock beside the folder says whether it is in use.
/// Thread:  owner.
class TemporaryFolder {
 public:
  /// `begin`: of its name.
  /// Errors:  denied, io; busy when no name was free.
  static Result<std::unique_ptr<TemporaryFolder>> make(const std::string& begin);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }

 private:
  TemporaryFolder(std::string path, std::unique_ptr<FileLock> lock) : path_(std::move(path)), lock_(std::move(lock)) {}
  std::string path_;
  std::unique_ptr<FileLock> lock_;  // taken before the folder is made, and held until it is gone
};

}  // namespace sinew::hal
