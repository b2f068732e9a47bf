#include "apps/sweep_runs/pack.hpp"

#include <gtest/gtest.h>

namespace sinew::app {
namespace {

TEST(ReadLdd, KeepsLibrariesAndLeavesThoseOfTheCLibrary) {
  std::vector<Library> libraries;
  std::string why;
  ASSERT_TRUE(
      read_ldd("\tlinux-vdso.so.1 (0x00007f)\n\tlibfmt.so.9 => /lib/libfmt.so.9 (0x00007f)\n"
               "\tlibm.so.6 => /lib/libm.so.6 (0x00007f)\n\tlibc.so.6 => /lib/libc.so.6 (0x00007f)\n"
               "\tlibmujoco.so.2.2.2 => /opt/libmujoco.so.2.2.2 (0x00007f)\n\t/lib64/ld-linux-x86-64.so.2 (0x7f)\n",
               libraries, why));
  ASSERT_EQ(libraries.size(), 2u);
  EXPECT_EQ(libraries[0].name, "libfmt.so.9");
  EXPECT_EQ(libraries[1].path, "/opt/libmujoco.so.2.2.2");
}

TEST(ReadLdd, NamesALibraryThatIsNotFound) {
  std::vector<Library> libraries;
  std::string why;
  EXPECT_FALSE(read_ldd("\tlibgone.so.1 => not found\n", libraries, why));
  EXPECT_EQ(why, "its library libgone.so.1 is not found");
}

TEST(ReadLdd, AStaticProgramHasNone) {
  std::vector<Library> libraries;
  std::string why;
  EXPECT_TRUE(read_ldd("\tstatically linked\n", libraries, why));
  EXPECT_TRUE(libraries.empty());
}

TEST(StaysBelow, OnlyANameThatAnotherFolderCanHave) {
  for (const char* name : {"quad.toml", "robots/quad/quad.toml", "./quad.toml", "a/../quad.toml"})
    EXPECT_TRUE(stays_below(name)) << name;
  for (const char* name : {"", "/robots/quad.toml", "../quad.toml", "a/../../quad.toml"})
    EXPECT_FALSE(stays_below(name)) << name;
}

}  // namespace
}  // namespace sinew::app
