#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "rt/module.hpp"

namespace sinew::rt {

/// The module types that a program knows, by the names that robot files use. Filled by an explicit list in the program:
///   types.add<control::RateController>("control::RateController");
/// Thread:  owner, configure only.
class ModuleTypes {
 public:
  using Factory = std::function<std::unique_ptr<Module>()>;

  template <class M>
  void add(std::string_view name) {
    add(name, [] { return std::make_unique<M>(); });
  }
  void add(std::string_view name, Factory factory) {
    factories_.insert_or_assign(std::string(name), std::move(factory));
  }

  /// Null when the type is not known.
  std::unique_ptr<Module> make(std::string_view name) const {
    const auto it = factories_.find(name);
    return it == factories_.end() ? nullptr : it->second();
  }
  /// In the order of the alphabet.
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& [name, factory] : factories_) all.push_back(name);
    return all;
  }

 private:
  std::map<std::string, Factory, std::less<>> factories_;
};

}  // namespace sinew::rt
