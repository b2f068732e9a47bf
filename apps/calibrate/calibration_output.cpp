#include "apps/calibrate/calibration_output.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "apps/command/command.hpp"

namespace sinew::app {
namespace {

/// In one piece. The exit code.
int write_text(const std::string& file, const std::string& text, bool quiet) {
  const std::string fresh = file + ".new";
  std::ofstream out(fresh, std::ios::binary);
  out << text;
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(fresh, file, error);
  if (!out || error) return fail(file + ": cannot be written", kFailed);
  if (!quiet) put_text("written: " + file + "\n");
  return kDone;
}

}  // namespace

bool read_calibration(const std::string& file, Calibration& all) {
  if (file.empty()) return true;
  std::ifstream in(file, std::ios::binary);
  if (!in) return true;  // the first one
  all = parse_calibration(std::string((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>()), file);
  for (const auto& p : all.problems) std::fprintf(stderr, "%s\n", rt::to_string(p, file).c_str());
  return all.problems.empty();
}

int write_calibration(const std::string& file, const std::string& robot, const Calibration& all, bool quiet) {
  const std::string text = calibration_text(robot, all);
  if (!file.empty()) return write_text(file, text, quiet);
  if (!quiet) put_text("\n" + text);
  return kDone;
}

void each_reader(const RobotFile& robot, const rt::ModuleTypes& types, const std::string& topic,
                 const std::function<void(const std::string& module, const rt::Declaration& declaration)>& each) {
  for (const rt::ModuleSpec& m : robot.graph.modules) {
    bool reads = false;
    for (const auto& [port, of] : m.in) reads = reads || of.value == topic;
    const auto made = reads ? types.make(m.type) : nullptr;
    if (!made) continue;
    rt::Declaration declaration;
    made->declare(declaration);
    each(m.name, declaration);
  }
}

int write_params(const OutputFiles& o, const std::string& robot, const std::vector<OverlayParam>& params) {
  Calibration all;
  if (!read_calibration(o.file, all)) return kNotBegun;
  for (const OverlayParam& p : params) {
    std::erase_if(all.params.params,
                  [&](const OverlayParam& old) { return old.module == p.module && old.param == p.param; });
    all.params.params.push_back(p);
  }
  if (!o.params.empty())
    if (const int code = write_text(o.params, overlay_text(robot, params), o.quiet); code != kDone) return code;
  if (o.file.empty() && (params.empty() || !o.params.empty())) return kDone;
  return write_calibration(o.file, robot, all, o.quiet);
}

}  // namespace sinew::app
