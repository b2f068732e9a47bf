#pragma once
#include <cstddef>
#include <cstdint>

/// Kernels over one row. In and out never overlap.
/// RT: yes.   Thread: any.
namespace sinew::images {

/// rgb to bgr, or back.
void swap_red_and_blue(const std::uint8_t* in, std::size_t pixels, std::uint8_t* out);

/// Three equal channels.
void grey_to_colour(const std::uint8_t* in, std::size_t pixels, std::uint8_t* out);

/// Y U Y V with limited range (Y 16 to 235, U and V 16 to 240) to RGB by BT.601, or to BGR. `in` is the first whole
/// pair; `odd` skips its first pixel. Source:  ITU-R BT.601-7, section 2.5.
void yuyv_to_colour(const std::uint8_t* in, bool odd, std::size_t pixels, bool bgr, std::uint8_t* out);

/// Y of each pixel of Y U Y V, from limited to full range, as JPEG has it; `in` is the Y of the first one.
/// Source:  ITU-T T.871 (JFIF), section 7.
void luma_of_yuyv(const std::uint8_t* in, std::size_t pixels, std::uint8_t* y);
/// U and V of each pair, to full range.
void chroma_of_yuyv(const std::uint8_t* in, std::size_t pairs, std::uint8_t* u, std::uint8_t* v);
/// The means of the U and V of two rows, rounded up, to full range.
void mean_chroma_of_yuyv(const std::uint8_t* in, const std::uint8_t* below, std::size_t pairs, std::uint8_t* u,
                         std::uint8_t* v);

/// PNG's filter Sub: each byte minus the byte `distance` before it, zero before the row.
void subtract_left(const std::uint8_t* in, std::size_t bytes, std::size_t distance, std::uint8_t* out);

/// sums[i] += weight * in[i]
void add_weighted(const std::uint8_t* in, std::size_t count, std::uint32_t weight, std::uint32_t* sums);

}  // namespace sinew::images
