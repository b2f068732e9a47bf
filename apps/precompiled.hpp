#pragma once
// What nearly all commands include, compiled once where SINEW_PRECOMPILED says so. Nobody includes this file: each file
// includes what it uses, and a build without SINEW_PRECOMPILED shows when one does not.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
