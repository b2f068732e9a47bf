// Linked into each test program: a temporary folder of its own, and in it a place where its robots meet nobody else's.
// When the program ends, what is still in there is named as a failure, and removed.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <string>

namespace sinew::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOf = "SINEW_TEST_FOLDER";  // for programs that a test starts: they share its folder

class OwnFolder final : public ::testing::Environment {
 public:
  void SetUp() override {
    if (::getenv(kOf)) return;
    std::string pattern = (fs::temp_directory_path() / "sinew-test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr) << pattern;
    folder_ = pattern;
    fs::permissions(folder_, fs::perms(0711));  // for tests that go on as another user
    ::setenv(kOf, folder_.c_str(), 1);
    ::setenv("TMPDIR", folder_.c_str(), 1);
    if (!::getenv("SINEW_RUN_DIR")) ::setenv("SINEW_RUN_DIR", run_dir().c_str(), 1);
  }

  void TearDown() override {
    if (folder_.empty()) return;
    std::error_code ended;  // a process that ends now may remove things while we look
    for (fs::recursive_directory_iterator at(folder_, ended), end; !ended && at != end; at.increment(ended))
      if (!is_ours(at->path()))
        ADD_FAILURE() << "left in the temporary folder: " << at->path().lexically_relative(folder_);
    fs::remove_all(folder_, ended);
  }

 private:
  fs::path run_dir() const { return folder_ / "run"; }

  /// GoogleTest's streams of a death test's child stay when that ends within a capture.
  bool is_ours(const fs::path& path) const {
    return path == run_dir() || path.filename().string().starts_with("gtest_captured_stream");
  }

  fs::path folder_;
};

[[maybe_unused]] const auto* const g_own_folder = ::testing::AddGlobalTestEnvironment(new OwnFolder);

}  // namespace
}  // namespace sinew::test
