#pragma once
// A case as text: the words that a command would be given, as a shell reads them.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sinew::sweep {

/// The words of a line, with '...' and "..." as a shell has them. Nothing: a quote has no end.
std::optional<std::vector<std::string>> split_words(std::string_view line);
/// One line that split_words() and a shell take apart again.
std::string joined(const std::vector<std::string>& words);

/// The value of `--seed`; nothing: it has none.
std::optional<std::string> seed_of(std::string_view run);
/// The same without its seed: what runs with several seeds share.
std::string without_seed(std::string_view run);
/// Its parts: the robot file, then each option with its value.
std::vector<std::string> parts_of(std::string_view run);

}  // namespace sinew::sweep
