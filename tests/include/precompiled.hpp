#pragma once
// Headers that nearly all tests include, compiled once with SINEW_PRECOMPILED. No file includes this one: each test
// includes what it uses, and a build without SINEW_PRECOMPILED shows when one does not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <sstream>
#include <string>
#include <thread>
#include <variant>
#include <vector>
