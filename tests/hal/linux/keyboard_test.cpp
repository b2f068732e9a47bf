#include "hal/linux/keyboard.hpp"

#include <gmock/gmock.h>

#include <vector>

namespace sinew::hal::keyboard_test {
namespace {

std::vector<Key> keys_of(std::string_view bytes) {
  std::vector<Key> keys;
  while (const auto key = take_key(bytes)) keys.push_back(*key);
  return keys;
}

TEST(Keyboard, ArrowsAreOneKeyInBothModesOfATerminal) {
  EXPECT_THAT(keys_of("\033[A\033[B\033OC\033OD"), testing::ElementsAre(Key::up, Key::down, Key::right, Key::left));
}

TEST(Keyboard, KeysThatComeTogetherAreTakenOneByOne) {
  EXPECT_THAT(keys_of("  x\033[C"), testing::ElementsAre(Key::space, Key::space, Key::other, Key::right));
}

TEST(Keyboard, PartsOfASequenceAreOtherKeys) {
  EXPECT_THAT(keys_of("\033"), testing::ElementsAre(Key::other));
  EXPECT_THAT(keys_of("\033[Z"), testing::ElementsAre(Key::other));
  EXPECT_TRUE(keys_of("").empty());
}

}  // namespace
}  // namespace sinew::hal::keyboard_test
