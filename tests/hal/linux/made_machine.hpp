#pragma once
// A machine made of files, for code that inspects machines.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "hal/linux/system_check.hpp"

namespace sinew::hal {

inline constexpr const char* kNoPrivilege = "Name:\tsinew\nCapEff:\t0000000000000000\nCpus_allowed_list:\t0-1\n";
inline constexpr const char* kRoot = "Name:\tsinew\nCapEff:\t000001ffffffffff\nCpus_allowed_list:\t0-1\n";

inline std::string limits(const std::string& priority, const std::string& locked) {
  return "Limit                     Soft Limit           Hard Limit           Units     \n"
         "Max locked memory         " +
         locked +
         "              8388608              bytes     \n"
         "Max realtime priority     " +
         priority + "                    99                        \n";
}

/// A machine as a folder of its own.
class Machine : public ::testing::Test {
 protected:
  Machine() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sinew_machine_XXXXXX").string();
    root_ = ::mkdtemp(pattern.data());
  }
  ~Machine() override { std::filesystem::remove_all(root_); }

  void file(const std::string& name, const std::string& text) {
    std::filesystem::create_directories((root_ / name).parent_path());
    std::ofstream(root_ / name) << text << "\n";
  }
  void cpus(int count) {
    for (int i = 0; i < count; ++i)
      std::filesystem::create_directories(root_ / "sys/devices/system/cpu" / ("cpu" + std::to_string(i)));
    file("sys/devices/system/cpu/online", "0-" + std::to_string(count - 1));
  }
  void irq_thread(const std::string& pid, const std::string& comm, int priority) {
    file("proc/" + pid + "/comm", comm);
    std::string stat = pid + " (" + comm + ") S";
    for (int field = 4; field < 40; ++field) stat += " " + std::to_string(field);
    file("proc/" + pid + "/stat", stat + " " + std::to_string(priority) + " 1 0");
  }
  void irq(int number, const std::string& handler, const std::string& cpus) {
    const std::string folder = "proc/irq/" + std::to_string(number) + "/";
    file(folder + "smp_affinity_list", cpus);
    std::filesystem::create_directories(root_ / (folder + handler));
  }
  void thread(const std::string& name, int priority, std::vector<int> cpus = {}) {
    demand.threads.push_back({name, priority, std::move(cpus), true});
  }
  SystemCheck look(const std::string& id) {
    for (const auto& c : check_system(SystemFiles(root_.string()), demand))
      if (c.id == id) return c;
    ADD_FAILURE() << "no check " << id;
    return {};
  }

  std::filesystem::path root_;
  SystemDemand demand;
};

}  // namespace sinew::hal
