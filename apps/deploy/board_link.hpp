#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::app {

/// The way to a board: each question is one run of ssh.
/// Thread:  owner.
class BoardLink {
 public:
  /// `ssh`: the program with its options, in words.
  BoardLink(const std::string& ssh, std::string host);

  struct Answer {
    int code = 0;  // of the script; 255: of ssh itself
    std::string out, errors;
  };
  struct Question {
    std::string_view script{};  // its name in apps/deploy
    std::vector<std::string> arguments{};
    bool root = false;
    std::function<std::string_view()> input{};       // as hal::PipedIo has it
    std::function<void(std::string_view)> output{};  // instead of Answer::out
  };
  /// Nothing when ssh could not even be started; problem() says why.
  std::optional<Answer> ask(const Question& question);
  const std::string& host() const { return host_; }
  const std::string& problem() const { return problem_; }

 private:
  std::vector<std::string> ssh_;
  std::string host_, problem_;
};

}  // namespace sinew::app
