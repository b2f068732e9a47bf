#pragma once
// Several values of one setting, as they are typed on a command line: A,B,C or FROM:TO:COUNT or FROM:TO:COUNT:log.
#include <string>
#include <vector>

#include "rt/declaration.hpp"

namespace sinew::app {

/// What the values are for.
enum class ValueKind {
  integer,  // a range gives whole numbers
  number,   // a range gives numbers; also where the kind is not known
  text      // there is no range: a colon is a part of the text
};

/// Of a parameter.
ValueKind value_kind(const rt::Declaration::Param& param);

/// Appends the values; those of a list may be anything. Errors: false, with `why`, for a malformed range.
bool value_list(const std::string& text, ValueKind kind, std::vector<rt::ParamValue>& values, std::string& why);

/// The whole argument, in words.
inline constexpr const char* kValueListForms = "MODULE.PARAM=FROM:TO:COUNT, the same with :log, or MODULE.PARAM=A,B,C";

}  // namespace sinew::app
