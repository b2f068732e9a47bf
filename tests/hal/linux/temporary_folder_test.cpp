#include "hal/linux/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace sinew::hal::temporary_folder_test {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<TemporaryFolder> made(const std::string& begin) {
  auto folder = TemporaryFolder::make(begin);
  EXPECT_TRUE(folder);
  return folder ? std::move(*folder) : nullptr;
}

TEST(TemporaryFolder, IsForItsOwnerOnlyAndGoesWithAllThatIsInIt) {
  std::string path;
  {
    const auto folder = made("sinew-folder-");
    path = folder->path();
    EXPECT_EQ(fs::status(path).permissions(), fs::perms{0700});
    std::ofstream(path + "/file") << "text";
  }
  EXPECT_FALSE(fs::exists(path));
  EXPECT_FALSE(fs::exists(path + ".lock"));
}

TEST(TemporaryFolder, AnotherOneOfTheSameBeginningIsNotTouchedWhileItIsInUse) {
  const auto one = made("sinew-folder-"), two = made("sinew-folder-");
  EXPECT_NE(one->path(), two->path());
  std::ofstream(one->path() + "/file") << "text";
  const auto three = made("sinew-folder-");
  EXPECT_TRUE(fs::exists(one->path() + "/file"));
  EXPECT_TRUE(fs::exists(two->path()));
}

TEST(TemporaryFolder, OnlyWhatIsNamedAsItsOwnIsRemoved) {
  const fs::path all = fs::temp_directory_path();
  const fs::path left = all / "sinew-folder-abcdef", longer = all / "sinew-folder-of-others",
                 file = all / "sinew-folder-ghijkl";
  fs::create_directory(left), fs::create_directory(longer);
  std::ofstream(file) << "text";
  { const auto folder = made("sinew-folder-"); }
  EXPECT_FALSE(fs::exists(left));
  EXPECT_TRUE(fs::exists(longer));
  EXPECT_TRUE(fs::exists(file));
  fs::remove(longer), fs::remove(file);
  for (const auto& entry : fs::directory_iterator(all))
    EXPECT_FALSE(entry.path().filename().string().starts_with("sinew-folder-")) << "left: " << entry.path();
}

TEST(TemporaryFolder, WithoutATemporaryFolderThereIsNone) {
  const std::string before = fs::temp_directory_path().string();
  ::setenv("TMPDIR", "/no/such/folder", 1);
  EXPECT_FALSE(TemporaryFolder::make("sinew-folder-"));
  ::setenv("TMPDIR", before.c_str(), 1);
}

}  // namespace
}  // namespace sinew::hal::temporary_folder_test
