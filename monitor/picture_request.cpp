#include "monitor/picture_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

namespace sinew::monitor {
namespace {

template <class T>
bool read_number(std::string_view text, T& value) {
  const auto got = std::from_chars(text.data(), text.data() + text.size(), value);
  return got.ec == std::errc() && got.ptr == text.data() + text.size();
}

bool read_region(std::string_view text, std::array<std::uint32_t, 4>& region) {
  for (std::size_t i = 0; i < region.size(); ++i) {
    const std::size_t comma = text.find(',');
    if ((comma == std::string_view::npos) != (i + 1 == region.size())) return false;
    if (!read_number(text.substr(0, comma), region[i])) return false;
    text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
  }
  return true;
}

bool read_argument(const std::string& name, const std::string& value, Recipe& recipe, std::string& why) {
  if (name == "quality") {
    if (read_number(value, recipe.options.quality) && recipe.options.quality >= 1 && recipe.options.quality <= 100)
      return true;
    why = fmt::format("quality={}: an integer from 1 to 100", value);
  } else if (name == "chroma") {
    if (value == "420" || value == "422") {
      recipe.options.chroma = value == "420" ? images::Chroma::yuv420 : images::Chroma::yuv422;
      return true;
    }
    why = fmt::format("chroma={}: 420 or 422", value);
  } else if (name == "scale") {
    if (read_number(value, recipe.cut.scale) && recipe.cut.scale > 0 && recipe.cut.scale <= 1) return true;
    why = fmt::format("scale={}: a number above 0, at most 1", value);
  } else if (name == "region") {
    std::array<std::uint32_t, 4> r{};
    if (read_region(value, r) && r[2] > 0 && r[3] > 0) {
      recipe.cut.x = r[0], recipe.cut.y = r[1], recipe.cut.width = r[2], recipe.cut.height = r[3];
      return true;
    }
    why = fmt::format("region={}: X,Y,WIDTH,HEIGHT in pixels", value);
  } else if (name == "t") {
    return true;  // pages add it to load a picture anew
  } else {
    why = fmt::format("{}: unknown; known are quality, chroma, scale, region", name);
  }
  return false;
}

}  // namespace

std::optional<PictureRequest> parse_picture_request(const Request& request, bool& is_picture, std::string& why) {
  constexpr std::string_view kFolder = "/images/";
  const std::string_view path = request.path;
  const std::size_t folder = path.find(kFolder, 1);
  is_picture = folder != std::string_view::npos && path.find('/', 1) == folder;
  if (!is_picture) return std::nullopt;
  PictureRequest r;
  r.robot = path.substr(1, folder - 1);
  const std::string_view file = path.substr(folder + kFolder.size());
  const std::size_t dot = file.rfind('.');
  const std::string_view ending = dot == std::string_view::npos ? std::string_view() : file.substr(dot + 1);
  r.topic = file.substr(0, dot);
  r.movie = ending == "mjpg";
  const auto kind = images::kind_of(r.movie ? "jpg" : ending);
  if (!kind) {
    why = fmt::format("'{}': a picture ends in .jpg, .png, .tiff or .bmp, a movie in .mjpg", file);
    return std::nullopt;
  }
  r.recipe.kind = *kind;
  for (const auto& [name, value] : request.query)
    if (!read_argument(name, value, r.recipe, why)) return std::nullopt;
  return r;
}

}  // namespace sinew::monitor
