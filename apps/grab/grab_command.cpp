#include "apps/grab/grab_command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/command/number_check.hpp"
#include "apps/command/place.hpp"
#include "apps/grab/grab_environment.hpp"
#include "apps/grab/grab_picture.hpp"
#include "hal/linux/grab/grab_session.hpp"
#include "hal/linux/grab/grab_view.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

constexpr hal::Duration kLookEvery = 50ms;  // whether the program has ended

struct GrabOptions {
  std::vector<std::string> command;
  std::string name, read = "direct";
  bool list = false, as_json = false, quiet = false;
  std::string from;
  PictureOptions picture;
};

/// The program's path, as a shell finds it; empty: there is none.
std::string program_of(const std::string& name) {
  if (name.find('/') != std::string::npos) return ::access(name.c_str(), X_OK) == 0 ? name : std::string();
  return find_in_path(name);
}

/// The session's name of a program: its file's, with what no name has replaced.
std::string session_name(const std::string& program) {
  std::string name = std::filesystem::path(program).filename().string().substr(0, 40);
  for (char& c : name)
    if (!hal::is_grab_name(std::string(1, c)) && c != '.') c = '_';
  if (!name.empty() && name.front() == '.') name.front() = '_';
  return name;
}

std::string words_of(const hal::GrabWindow& w) {
  return fmt::format("window {}: {} of '{}' (process {}), {}x{}{}", w.number, w.api, w.program, w.pid, w.width,
                     w.height, w.title.empty() ? "" : ", '" + w.title + "'");
}

json json_of(const hal::GrabWindow& w) {
  return {{"window", w.number}, {"program", w.program},   {"pid", w.pid}, {"api", w.api},    {"width", w.width},
          {"height", w.height}, {"pictures", w.pictures}, {"id", w.id},   {"title", w.title}};
}

int list_sessions(bool as_json) {
  json all = json::array();
  for (const std::string& name : hal::grab_sessions()) {
    std::string why;
    const auto windows = hal::grab_windows(name, why);
    if (!windows) continue;  // it ended just now
    if (!as_json) fmt::print("{}{}\n", name, windows->empty() ? ": shows no pictures yet" : "");
    json one{{"name", name}, {"windows", json::array()}};
    for (const hal::GrabWindow& w : *windows) {
      one["windows"].push_back(json_of(w));
      if (!as_json) fmt::print("  {}, {} pictures\n", words_of(w), w.pictures);
    }
    all.push_back(std::move(one));
  }
  if (as_json)
    fmt::print("{}\n", all.dump(2));
  else if (all.empty())
    fmt::print("no program is grabbed: sinew grab PROGRAM\n");
  return kDone;
}

/// Tells of windows that were not there before.
class WindowNews {
 public:
  void tell(const std::string& name, const grab::Head& head) {
    if (const std::uint32_t change = head.windows.load(std::memory_order_acquire); change != seen_) {
      seen_ = change;
      for (const hal::GrabWindow& w : hal::windows_of(head)) {
        const bool known = (known_ >> w.number & 1) != 0;
        known_ |= 1u << w.number;
        // A title comes a moment after its window; what programs count in theirs is not told.
        const bool has_title_now = titles_[w.number].empty() && !w.title.empty();
        if (!known)
          fmt::print(stderr, "grab: {}: {}\n", name, words_of(w));
        else if (has_title_now)
          fmt::print(stderr, "grab: {}: window {}: title '{}'\n", name, w.number, w.title);
        if (!known || has_title_now) titles_[w.number] = w.title;
      }
    }
  }

 private:
  std::uint32_t seen_ = 0, known_ = 0;
  std::array<std::string, grab::kMaxWindows> titles_;
};

int take_picture(const std::string& session, const PictureOptions& options) {
  PictureTaker taker(session, options);
  for (;;) {
    if (const auto code = taker.poll()) return *code;
    if (hal::stop_requested()) return fail("stopped before the picture was there", kFailed);
    hal::system_os().sleep_until(hal::system_os().now() + 10ms);
  }
}

/// Serves until the program and all that it started have ended. Its exit code; with `taker`, which is the process that
/// takes a picture, that one's.
int serve_program(hal::GrabSession& session, hal::ChildProcess& child, hal::ChildProcess* taker, const GrabOptions& o) {
  WindowNews news;
  std::optional<int> code, picture;
  unsigned stops = 0;
  for (;;) {
    if (!session.serve(kLookEvery)) return fail("the session's socket broke", kFailed);
    if (!o.quiet) news.tell(o.name, session.head());
    if (!code) code = child.poll();
    if (hal::stop_signals() != stops) {
      stops = hal::stop_signals();
      child.terminate();
    }
    if (taker && !picture) {
      picture = taker->poll();
      if (picture) child.terminate();
    }
    // A launcher ends while the program that it started goes on.
    if (code && session.programs() == 0) break;
  }
  if (taker) return picture ? *picture : fail("the program ended before the picture was there", kFailed);
  if (session.programs_seen() == 0 && !o.quiet)
    fmt::print(stderr, "grab: {} showed no picture by OpenGL or Vulkan{}\n", o.name,
               *code == kDone ? "" : "; " + hal::describe_exit(*code));
  return *code;
}

int run_program(GrabOptions o) {
  const std::string program = program_of(o.command.front());
  if (program.empty()) return fail(o.command.front() + ": no such program");
  if (o.name.empty()) o.name = session_name(program);
  std::string why;
  auto session = hal::GrabSession::open(o.name, why);
  if (!session) return fail(why);
  if (!set_grab_environment((*session)->path(), o.read == "buffered", why)) return fail(why);
  static_cast<void>(hal::stop_requested());
  std::vector<std::string> argv = o.command;
  argv.front() = program;
  auto child = hal::ChildProcess::start(argv);
  if (!child) return fail(program + ": " + std::strerror(static_cast<int>(child.error().detail)));
  std::unique_ptr<hal::ChildProcess> taker;
  if (!o.picture.file.empty()) {
    auto copy = hal::ChildProcess::fork([&o] { return take_picture(o.name, o.picture); },
                                        {.hears_terminal = false, .killed_when_we_die = true});
    if (!copy) return fail("no process for the picture", kFailed);
    taker = std::move(*copy);
  }
  return serve_program(**session, **child, taker.get(), o);
}

int grab(const GrabOptions& o) {
  if (o.list) return list_sessions(o.as_json);
  if (!o.from.empty()) {
    if (o.picture.file.empty()) return fail("--from needs --to FILE.png");
    return take_picture(o.from, o.picture);
  }
  return run_program(o);
}

}  // namespace

void add_grab_command(CLI::App& app, CommandContext& context) {
  const auto o = std::make_shared<GrabOptions>();
  CLI::App* grabbed = app.add_subcommand("grab", kGrabAbout);
  grabbed->add_option("--name", o->name, "of the session, as a robot file has it; default: the program's file name")
      ->check([](const std::string& name) {
        return hal::is_grab_name(name) ? std::string() : "letters, digits, _, ., + and -, at most 40";
      });
  grabbed
      ->add_option(
          "--read", o->read,
          "how pictures are read: direct (in the program's own swap) or buffered (one picture later, without a "
          "wait where there is a GPU)")
      ->check(CLI::IsMember({"direct", "buffered"}))
      ->capture_default_str();
  grabbed->add_flag("--list", o->list, "what is grabbed now, with all windows");
  grabbed->add_flag("--json", o->as_json, "with --list: for programs");
  grabbed->add_option("--from", o->from, "with --to: of a session that runs already");
  grabbed->add_option("--to", o->picture.file, "one picture into this file (png, jpg, bmp, tif), then the program ends")
      ->type_name(kFileHint);
  grabbed->add_option("--after", o->picture.after_s, "with --to: seconds after the first picture")
      ->check(number(0, 3600))
      ->capture_default_str();
  grabbed->add_option("--window", o->picture.window, "with --to: number of the window; -1: the one that shows pictures")
      ->check(number(-1, 15))
      ->capture_default_str();
  grabbed
      ->add_option(
          "--title", o->picture.title,
          "with --to: instead of --window: the window with this title, else the only one whose title contains it")
      ->excludes("--window");
  grabbed->add_option("--region", o->picture.region, "with --to: part of the window, pixels from its top left")
      ->type_name("X,Y,WIDTH,HEIGHT");
  grabbed->add_flag("--quiet", o->quiet, "do not tell of windows");
  grabbed->prefix_command();  // what follows the program's name is the program's
  grabbed->callback([&context, o, grabbed] {
    o->command = grabbed->remaining();
    if (!o->command.empty() && o->command.front() == "--") o->command.erase(o->command.begin());
    if (!o->command.empty() && o->command.front().starts_with('-')) throw CLI::ExtrasError({o->command.front()});
    if (!o->list && o->from.empty() && o->command.empty()) throw CLI::RequiredError("program");
    context.action = [o] { return grab(*o); };
  });
}

}  // namespace sinew::app
