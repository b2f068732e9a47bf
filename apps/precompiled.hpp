#pragma once
// Headers of nearly all commands, compiled once with SINEW_PRECOMPILED. Do not include this file: each file includes
// what it uses, and a build without SINEW_PRECOMPILED fails where an include is missing.
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
