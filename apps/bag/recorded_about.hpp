#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "record/reader.hpp"
#include "rt/graph.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {

/// What a file says of the robot whose run it holds. All of it may be missing.
struct RecordedAbout {
  std::string robot, board;
  bool virtual_time = false;
  /// The graph of the attached robot file, neither checked nor configured: types and parameters that this program does
  /// not have are missing in it.
  std::unique_ptr<rt::Graph> graph;
  std::vector<std::string> threads, modules;  // by their numbers in the file
  std::vector<std::uint32_t> thread_of;       // by module: number of its thread
  record::Texts params;                       // "attitude.kp" of the beginning, as rt::to_string() writes it
  struct ParamChange {
    rt::Time at;
    std::uint32_t module = 0, index = 0;  // numbers in the file, and in the module's declaration
    rt::ParamValue value;
  };
  std::vector<ParamChange> changes;  // by requests, in the order of time; of many the first ones

  /// The declared parameter and its value at a time, by the modules' order in the robot file.
  struct Param {
    std::string module;
    const rt::Declaration::Param* declared = nullptr;
    rt::ParamValue value;
  };
  std::vector<Param> params_at(rt::Time at) const;
};

/// Reads it. Damaged parts of the file are as if they were missing: who plays the file names them.
/// `file`: its path, for messages. `types`: what this program knows of modules.
/// Thread:  the reader's owner.
RecordedAbout recorded_about(record::Reader& reader, const std::string& file, const rt::ModuleTypes& types);

}  // namespace sinew::app
