#include "apps/deploy/board_link.hpp"

#include <fmt/format.h>

#include "apps/deploy/board_shell.hpp"
#include "hal/linux/piped_process.hpp"

namespace sinew::app {

BoardLink::BoardLink(const std::string& ssh, std::string host) : ssh_(split_words(ssh)), host_(std::move(host)) {
  // Makes ssh report a board that is off, or a lost network, within seconds. The user's own options win: of equal
  // options ssh takes the first.
  if (!ssh_.empty() && (ssh_[0] == "ssh" || ssh_[0].ends_with("/ssh")))
    for (const char* option : {"ConnectTimeout=10", "ServerAliveInterval=10", "ServerAliveCountMax=3"}) {
      ssh_.emplace_back("-o");
      ssh_.emplace_back(option);
    }
}

std::optional<BoardLink::Answer> BoardLink::ask(const Question& question) {
  if (ssh_.empty()) {
    problem_ = "--ssh: the name of a program";
    return std::nullopt;
  }
  std::vector<std::string> argv = ssh_;
  argv.push_back(host_);
  argv.push_back(shell_line(board_script(question.script), question.arguments, question.root));
  Answer answer;
  hal::PipedIo io;
  io.input = question.input;
  io.output = question.output ? question.output : [&](std::string_view text) { answer.out += text; };
  io.errors = [&](std::string_view text) { answer.errors += text; };
  const auto code = hal::run_piped(argv, io);
  if (!code) {
    problem_ =
        code.error().code == hal::Errc::not_found
            ? fmt::format("there is no program '{}' (Debian: apt-get install openssh-client)", ssh_[0])
            : fmt::format("{}: cannot be run ({} {})", ssh_[0], hal::to_string(code.error().code), code.error().detail);
    return std::nullopt;
  }
  answer.code = *code;
  return answer;
}

}  // namespace sinew::app
