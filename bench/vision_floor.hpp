#pragma once
// The least code that does the work of vision/, for one fixed frame size, with every instruction of an AVX2 and FMA
// machine: no bounds, no other formats, no counters. vision_bench compares with it.
#include <array>
#include <cstdint>
#include <vector>

namespace sinew::bench::floor {

inline constexpr int kWidth = 640, kHeight = 480, kColours = 4;

struct Box {
  std::uint8_t lo[3], hi[3];
};

void segmentation_setup(const std::array<Box, kColours>& boxes);
int segment_table(const std::uint8_t* yuyv, int min_area);  // blobs found
int segment_boxes(const std::uint8_t* yuyv, int min_area);

// Frames have 64 readable bytes behind them.
void emd_polar(const std::uint8_t* older, const std::uint8_t* newer, float* magnitude, float* direction);
void emd_sums(const std::uint8_t* older, const std::uint8_t* newer, std::int64_t* sums);

// The mean of each square of 4 x 4 pixels, rounded.
void bin4_yuyv(const std::uint8_t* yuyv, std::uint8_t* out);
void bin4_mono(const std::uint8_t* mono, std::uint8_t* out);

}  // namespace sinew::bench::floor
