#include "record/crc32.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <string_view>
#include <vector>

namespace sinew::record::crc32_test {
namespace {

std::span<const std::byte> bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

/// One bit after the other, as the definition has it.
std::uint32_t bit_by_bit(std::span<const std::byte> message) {
  std::uint32_t sum = 0xFFFFFFFF;
  for (const std::byte b : message) {
    sum ^= std::to_integer<std::uint32_t>(b);
    for (int i = 0; i < 8; ++i) sum = (sum >> 1) ^ ((sum & 1) != 0 ? 0xEDB88320u : 0u);
  }
  return ~sum;
}

std::vector<std::byte> noise(std::size_t size) {
  std::mt19937 random(7);
  std::vector<std::byte> out(size);
  for (auto& b : out) b = static_cast<std::byte>(random());
  return out;
}

TEST(Crc32, HasThePublishedCheckValue) {
  EXPECT_EQ(crc32(bytes("123456789")), 0xCBF43926u);
  EXPECT_EQ(crc32({}), 0u);
}

TEST(Crc32, EqualsItsDefinitionForEveryLengthAndPlace) {
  const auto message = noise(700);
  for (std::size_t size = 0; size < 600; ++size)
    for (const std::size_t place : {0u, 1u, 7u, 16u, 33u}) {
      const auto piece = std::span(message).subspan(place, size);
      ASSERT_EQ(crc32(piece), bit_by_bit(piece)) << size << " at " << place;
    }
}

TEST(Crc32, EqualsItsDefinitionForLongMessages) {
  const auto message = noise(9000);
  for (std::size_t size = 1000; size < 8900; size += 1 + size % 37)
    for (const std::size_t place : {0u, 5u, 64u}) {
      const auto piece = std::span(message).subspan(place, size);
      ASSERT_EQ(crc32(piece), bit_by_bit(piece)) << size << " at " << place;
    }
}

TEST(Crc32, CarriesOnWhereverTheMessageIsCut) {
  const auto message = noise(400);
  const std::span<const std::byte> all(message);
  for (std::size_t cut = 0; cut <= all.size(); ++cut) {
    const auto head = all.first(cut), tail = all.subspan(cut);
    ASSERT_EQ(crc32(tail, crc32(head)), crc32(all)) << cut;
    ASSERT_EQ(crc32_joined(crc32(head), crc32(tail), tail.size()), crc32(all)) << cut;
  }
}

}  // namespace
}  // namespace sinew::record::crc32_test
