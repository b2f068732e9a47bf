#pragma once
// Commands for another machine: ssh carries them as one line of text, which any shell there can read.
#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::app {

/// One of apps/deploy/*.sh, by its name without the ending; empty: there is none.
std::string_view board_script(std::string_view name);

/// In single quotes, which sh, bash, csh and fish read alike.
std::string shell_quoted(std::string_view text);

/// The line that runs a POSIX script with these arguments on the board; `root`: by sudo.
std::string shell_line(std::string_view script, const std::vector<std::string>& arguments, bool root);

/// "ssh -p 2222" as words; there are no quotes.
std::vector<std::string> split_words(std::string_view text);

/// Calls each(line) for the lines of a text, without their ends.
template <class Each>
void each_line(std::string_view text, Each each) {
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    each(text.substr(0, end));
    text.remove_prefix(std::min(text.size(), end + 1));
  }
}

/// Output of a script, cut at its marks: lines "::sinew NAME". Leaves out what a login prints before the first mark.
class MarkedText {
 public:
  explicit MarkedText(std::string_view text);
  /// The lines behind a mark; nothing when it did not come.
  std::optional<std::string> after(std::string_view mark) const;
  /// The rest of the line of the mark that begins with `word`: of "deployed version-3" the "version-3".
  std::optional<std::string> word_after(std::string_view word) const;

 private:
  struct Part {
    std::string mark, body;
  };
  std::vector<Part> parts_;
};

}  // namespace sinew::app
