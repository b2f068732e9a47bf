#include "apps/grab/grab_picture.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>

#include "apps/command/command.hpp"
#include "hal/platform.hpp"
#include "images/encode.hpp"

namespace sinew::app {
namespace {

constexpr hal::Duration kPatienceWithTitles = std::chrono::seconds(3);

std::string ending_of(const std::string& file) {
  const std::size_t dot = file.rfind('.');
  return dot == std::string::npos ? std::string() : file.substr(dot + 1);
}

}  // namespace

bool read_region(const std::string& text, hal::GrabRegion& region) {
  std::int64_t numbers[4];
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int i = 0; i < 4; ++i) {
    const auto read = std::from_chars(at, end, numbers[i]);
    if (read.ec != std::errc()) return false;
    at = read.ptr;
    if (i < 3 && (at == end || *at++ != ',')) return false;
  }
  const auto side = static_cast<std::int64_t>(grab::kMaxSide);
  if (at != end || numbers[0] < -side || numbers[0] > side || numbers[1] < -side || numbers[1] > side ||
      numbers[2] < 0 || numbers[2] > side || numbers[3] < 0 || numbers[3] > side)
    return false;
  region = {static_cast<std::int32_t>(numbers[0]), static_cast<std::int32_t>(numbers[1]),
            static_cast<std::uint32_t>(numbers[2]), static_cast<std::uint32_t>(numbers[3])};
  return true;
}

PictureTaker::PictureTaker(std::string session, const PictureOptions& options)
    : session_(std::move(session)), options_(options) {
  if (!options_.region.empty()) region_is_good_ = read_region(options_.region, region_);
}

std::optional<int> PictureTaker::opened() {
  std::string why;
  auto view = hal::GrabView::open(session_, why);
  if (!view) return fail(why, kFailed);
  view_ = std::move(*view);
  return std::nullopt;
}

std::optional<int> PictureTaker::poll() {
  if (!region_is_good_)
    return fail(fmt::format("--region {}: four whole numbers X,Y,WIDTH,HEIGHT; 0: to the border", options_.region));
  const auto kind = images::kind_of(ending_of(options_.file));
  if (!kind || !images::is_built(*kind)) return fail(options_.file + ": png, jpg, bmp or tif");
  if (!view_)
    if (const auto code = opened()) return code;
  std::uint32_t window = options_.window < 0 ? hal::GrabView::kAnyWindow : static_cast<std::uint32_t>(options_.window);
  if (!options_.title.empty()) {
    window = view_->titled(options_.title).window;
    if (window == grab::kNoNumber) return untitled();
    view_->point_at(window);
  }
  if (view_->open_asks() == 0) view_->ask(window, region_, due_.value_or(hal::Time{0}));
  const auto picture = view_->oldest();
  if (!picture) {
    if (!view_->is_connected())
      return fail("the session '" + session_ + "' ended before the picture was there", kFailed);
    return std::nullopt;
  }
  if (!due_) {  // the first picture: the wanted one comes `after`
    due_ = picture->shown + hal::Duration{static_cast<std::int64_t>(options_.after_s * 1e9)};
    if (options_.after_s > 0) {
      view_->take();
      return std::nullopt;
    }
  }
  if (picture->status != grab::AnswerStatus::ok)
    return fail(options_.file + ": " + hal::words_of(picture->status), kFailed);
  return written(*picture);
}

/// No window has the title: titles come a moment after their windows, and programs open one window after another.
std::optional<int> PictureTaker::untitled() {
  if (!view_->is_connected()) return fail("the session '" + session_ + "' ended before the picture was there", kFailed);
  const std::vector<hal::GrabWindow> windows = view_->windows();
  const hal::Time now = hal::system_os().now();
  if (windows.empty()) windows_since_.reset();
  if (!windows.empty() && !windows_since_) windows_since_ = now;
  if (!windows_since_ || now - *windows_since_ < kPatienceWithTitles) return std::nullopt;
  return fail(fmt::format("{} has '{}' in its title; there are: {}",
                          view_->titled(options_.title).count > 1 ? "not one window alone" : "no window",
                          options_.title, hal::titles_of(windows)),
              kFailed);
}

int PictureTaker::written(const hal::GrabPicture& p) const {
  std::vector<std::uint8_t> rgb(std::size_t{p.width} * p.height * 3);
  std::uint8_t* out = rgb.data();
  const int red = p.order == grab::PixelOrder::rgbx ? 0 : 2;
  for (std::uint32_t y = 0; y < p.height; ++y) {
    const std::uint8_t* in = p.row(y);
    for (std::uint32_t x = 0; x < p.width; ++x, in += 4, out += 3)
      out[0] = in[red], out[1] = in[1], out[2] = in[2 - red];
  }
  images::Encoder encoder;
  const auto file = encoder.encode({rgb, p.width, p.height, p.width * 3, msg::PixelFormat::rgb8},
                                   *images::kind_of(ending_of(options_.file)));
  if (!file) return fail(options_.file + ": " + file.error().where, kFailed);
  std::FILE* const to = std::fopen(options_.file.c_str(), "wb");
  if (!to) return fail(options_.file + ": " + std::strerror(errno), kFailed);
  const bool whole = std::fwrite(file->data(), 1, file->size(), to) == file->size();
  if (std::fclose(to) != 0 || !whole) return fail(options_.file + ": " + std::strerror(errno), kFailed);
  return kDone;
}

}  // namespace sinew::app
