#include "apps/deploy/deploy_failure.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/deploy/board_shell.hpp"

namespace sinew::app {
namespace {

struct Library {
  std::string_view soname, package;
};
// Debian 12. What the program and its optional parts need.
constexpr Library kLibraries[] = {{"libfmt.so.9", "libfmt9"},
                                  {"libpng16.so.16", "libpng16-16"},
                                  {"liblz4.so.1", "liblz4-1"},
                                  {"libzstd.so.1", "libzstd1"},
                                  {"libz.so.1", "zlib1g"},
                                  {"libstdc++.so.6", "libstdc++6"},
                                  {"libgcc_s.so.1", "libgcc-s1"},
                                  {"libatomic.so.1", "libatomic1"},
                                  {"libopencv_core.so.406", "libopencv-core406"},
                                  {"libopencv_imgproc.so.406", "libopencv-imgproc406"},
                                  {"libturbojpeg.so.0", "libturbojpeg0"},
                                  {"libcamera.so.0.0.3", "libcamera0.0.3"},
                                  {"libcamera-base.so.0.0.3", "libcamera0.0.3"}};

std::string last_line(std::string_view text) {
  std::string last;
  each_line(text, [&](std::string_view line) {
    if (line.find_first_not_of(" \t\r") != std::string_view::npos) last = line;
  });
  while (!last.empty() && last.back() == '\r') last.pop_back();
  return last;
}

/// Explains an error text of ssh, which is English, and says what to do.
std::string explain_ssh(std::string_view errors, const std::string& host) {
  struct Known {
    const char *says, *means;
  };
  constexpr Known kKnown[] = {
      {"Could not resolve hostname", "this name is not known here: is it right, is the board in the network?"},
      {"Connection refused",
       "the board answers, but no ssh server does: is sshd running, is the port right (--ssh "
       "\"ssh -p PORT\")?"},
      {"No route to host", "the board cannot be reached: is it on, and in this network?"},
      {"Network is unreachable", "the board cannot be reached: is it on, and in this network?"},
      {"timed out", "the board does not answer: is it on, and in this network?"},
      {"Host key verification failed", "the board's key is not the known one: log in once by hand with ssh"},
      {"Permission denied", "the board refuses this login: a wrong user, or a key that it does not know (ssh-copy-id)"},
      {"Broken pipe", "the connection broke"},
      {"Connection reset", "the connection broke"},
      {"closed by remote host", "the connection broke"}};
  for (const auto& k : kKnown)
    if (errors.find(k.says) != std::string_view::npos)
      return fmt::format("{}: {} (ssh: {})", host, k.means, last_line(errors));
  return fmt::format("{}: ssh failed: {}", host, errors.empty() ? "it does not say why" : last_line(errors));
}

}  // namespace

std::vector<std::string> missing_libraries(std::string_view loader) {
  std::vector<std::string> missing;
  each_line(loader, [&](std::string_view line) {
    const auto arrow = line.find(" => not found");
    const auto first = line.find_first_not_of(" \t");
    if (arrow == std::string_view::npos || first >= arrow) return;
    std::string name(line.substr(first, arrow - first));
    for (const auto& known : kLibraries)
      if (name == known.soname) name += fmt::format(" (Debian: apt-get install {})", known.package);
    if (std::find(missing.begin(), missing.end(), name) == missing.end()) missing.push_back(name);
  });
  return missing;
}

std::string too_old_library(std::string_view loader) {
  std::string found;
  each_line(loader, [&](std::string_view line) {
    if (found.empty() && line.find("version `") != std::string_view::npos &&
        line.find("' not found") != std::string_view::npos)
      found = line;
  });
  return found;
}

std::string explain_failure(int code, std::string_view errors, const std::string& host, const std::string& folder) {
  if (code == 255) return explain_ssh(errors, host);
  const std::string said = errors.empty() ? "" : ": " + last_line(errors);
  if (errors.find("No space left on device") != std::string_view::npos)
    return fmt::format("{}: the board's disk is full{}", folder, said);
  if (errors.find("Read-only file system") != std::string_view::npos)
    return fmt::format("{}: the board's file system is mounted read-only (mount -o remount,rw){}", folder, said);
  if (errors.find("sudo: ") != std::string_view::npos) return fmt::format("sudo on the board refuses{}", said);
  switch (static_cast<BoardStep>(code)) {
    case BoardStep::folder:
      return fmt::format("{}: this folder cannot be made{}", folder, said);
    case BoardStep::unpack:
      return fmt::format("{}: what was sent could not be unpacked whole{}", folder, said);
    case BoardStep::write:
      return fmt::format("{}: a file could not be written{}", folder, said);
    case BoardStep::start:
      return fmt::format("the program does not start on the board{}", said);
    case BoardStep::check:
      return "the robot file does not pass on the board; the version before stays";
    case BoardStep::swap:
      return fmt::format("{}: the new version could not take its place{}", folder, said);
    case BoardStep::no_previous:
      return fmt::format("{}: there is no version before this one", folder);
    case BoardStep::user:
      return fmt::format("the unit's user could not be made{}", said);
    case BoardStep::data:
      return fmt::format("the folder for runs could not be made{}", said);
    case BoardStep::reach:
      return fmt::format("{}: the unit's user cannot enter this folder: take one like /opt/sinew", folder);
    case BoardStep::unit:
      return fmt::format("the unit could not be written{}", said);
    case BoardStep::enable:
      return fmt::format("systemctl refuses the unit{}", said);
    case BoardStep::ill:
      return "not started: the doctor found problems";
    case BoardStep::running:
      return "not started: it runs already, with the version before; `systemctl restart` on the board, when the robot "
             "is where it may stop, changes that";
    case BoardStep::started:
      return fmt::format("the unit did not start{}", said);
    case BoardStep::no_data:
      return fmt::format("{}: there is no folder of runs (--data DIR names it){}", folder, said);
    case BoardStep::unreadable:
      return fmt::format("a file cannot be read by this login{}", said);
  }
  return fmt::format("the board ended with exit code {}{}", code, said);
}

}  // namespace sinew::app
