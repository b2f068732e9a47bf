#include "monitor/program.hpp"

#include <fmt/format.h>

#include <utility>

namespace sinew::monitor {
namespace {

using Clock = std::chrono::steady_clock;

/// Why the program has to end now; empty: it may go on.
std::string limit_reached(const ProgramEnd& so_far, const ProgramLimits& limits, Clock::time_point begun,
                          const std::atomic<bool>& stop) {
  if (stop.load()) return "it was ended";
  if (Clock::now() - begun > limits.patience)
    return fmt::format("it took longer than {} s and was ended",
                       std::chrono::duration_cast<std::chrono::seconds>(limits.patience).count());
  if (so_far.output.size() + so_far.errors.size() > limits.most_bytes)
    return fmt::format("it printed more than {} bytes and was ended", limits.most_bytes);
  return {};
}

}  // namespace

ProgramEnd run_program(const std::vector<std::string>& argv, const ProgramLimits& limits, const std::atomic<bool>& stop,
                       const std::function<void(int pid)>& started) {
  ProgramEnd end;
  const auto begun = Clock::now();
  // In a group of its own: the keys of our terminal are not for it, and what it starts ends with it.
  auto child = hal::ChildProcess::start(argv, hal::ChildOptions{.piped = true, .own_group = true});
  if (!child) {
    end.why = fmt::format("{}: {}", argv[0], hal::to_string(child.error().code));
    return end;
  }
  if (started) started((*child)->pid());
  hal::ChildProcess* const one[] = {child->get()};
  std::vector<std::size_t> ready;
  while (!(end.exit_code = (*child)->poll())) {
    if (end.why = limit_reached(end, limits, begun, stop); !end.why.empty()) return end;
    hal::ChildProcess::wait_for_any(one, kStopLook, ready);
    (*child)->read_output(end.output, end.errors);
  }
  while ((*child)->read_output(end.output, end.errors)) {
  }
  return end;
}

Program::Program(std::vector<std::string> argv, ProgramLimits limits, std::function<void(ProgramEnd)> on_end)
    : thread_([this, argv = std::move(argv), limits, on_end = std::move(on_end)] {
        on_end(run_program(argv, limits, stop_, [this](int pid) { pid_.store(pid); }));
      }) {}

Program::~Program() {
  end();
  thread_.join();
}

namespace {

/// Of those that are not empty: where a program of ours says why it ended.
std::string last_line(const std::string& text) {
  const std::size_t end = text.find_last_not_of(" \r\n");
  if (end == std::string::npos) return {};
  const std::size_t begin = text.find_last_of('\n', end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1,
                     end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

}  // namespace

std::string reason(const ProgramEnd& end) {
  if (!end.why.empty()) return end.why;
  const std::string said = last_line(end.errors);
  return said.empty() ? hal::describe_exit(end.exit_code.value_or(0)) : said;
}

}  // namespace sinew::monitor
