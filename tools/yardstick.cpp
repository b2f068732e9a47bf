// How fast a machine compiles today: ./test --ci compiles this file and prints the seconds (docs/stage-times.md). It
// uses nothing of Sinew, so that its time tells about the machine only, and is not to be changed.
#include <algorithm>
#include <functional>
#include <iostream>
#include <map>
#include <regex>
#include <string>
#include <vector>

int main(int argc, char** argv) {
  std::map<std::string, std::vector<std::size_t>> places;
  const std::regex word("([a-z]+)([0-9]*)");
  for (int i = 1; i < argc; ++i) {
    const std::string text = argv[i];
    for (std::sregex_iterator found(text.begin(), text.end(), word), end; found != end; ++found)
      places[(*found)[1]].push_back(static_cast<std::size_t>(found->position()));
  }
  std::vector<std::function<bool()>> checks;
  for (auto& [name, list] : places)
    checks.emplace_back([&list = list] { return std::is_sorted(list.begin(), list.end()); });
  const auto good = std::count_if(checks.begin(), checks.end(), [](const auto& check) { return check(); });
  std::cout << good << " of " << checks.size() << '\n';
}
