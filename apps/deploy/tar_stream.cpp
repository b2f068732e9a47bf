#include "apps/deploy/tar_stream.hpp"

#include <algorithm>

namespace sinew::app {
namespace {

constexpr std::size_t kBlock = 512, kName = 100, kPrefix = 155;

void put(std::string& block, std::size_t at, std::string_view text) { std::copy(text.begin(), text.end(), &block[at]); }

/// Octal digits with a zero byte behind them, `width` bytes in total.
void put_octal(std::string& block, std::size_t at, std::size_t width, std::uint64_t value) {
  for (std::size_t i = width - 1; i-- > 0; value /= 8) block[at + i] = static_cast<char>('0' + value % 8);
}

/// Where a long name is cut into prefix and name; npos: nowhere.
std::size_t cut_of(std::string_view name) {
  const auto first = name.size() - kName - 1;  // the rest must fit
  const auto cut = name.find('/', first);
  return cut == std::string_view::npos || cut == 0 || cut > kPrefix || cut + 1 == name.size() ? std::string_view::npos
                                                                                              : cut;
}

}  // namespace

std::string tar_header(std::string_view name, std::uint64_t size, bool executable, std::int64_t changed_s) {
  if (name.empty() || size >= std::uint64_t{1} << 33) return {};
  std::string block(kBlock, '\0');
  if (name.size() <= kName) {
    put(block, 0, name);
  } else {
    const auto cut = cut_of(name);
    if (cut == std::string_view::npos) return {};
    put(block, 345, name.substr(0, cut));
    put(block, 0, name.substr(cut + 1));
  }
  put_octal(block, 100, 8, executable ? 0755 : 0644);
  put_octal(block, 108, 8, 0);  // user
  put_octal(block, 116, 8, 0);  // group
  put_octal(block, 124, 12, size);
  put_octal(block, 136, 12, static_cast<std::uint64_t>(std::max<std::int64_t>(0, changed_s)));
  block[156] = '0';  // an ordinary file
  put(block, 257, std::string_view("ustar\00000", 8));
  put(block, 148, "        ");  // the checksum counts itself as blanks
  std::uint64_t sum = 0;
  for (const char c : block) sum += static_cast<unsigned char>(c);
  put_octal(block, 148, 7, sum);
  block[154] = '\0', block[155] = ' ';
  return block;
}

std::string tar_padding(std::uint64_t size) { return std::string((kBlock - size % kBlock) % kBlock, '\0'); }

}  // namespace sinew::app
