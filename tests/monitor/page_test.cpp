#include "monitor/page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>

namespace sinew::monitor::page_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Got {
  bool ours = false;
  Response response{};
  std::string header(const std::string& name) const {
    for (const auto& [key, value] : response.headers)
      if (key == name) return value;
    return "";
  }
  std::string body() const {
    if (!response.body) return "";
    return {reinterpret_cast<const char*>(response.body->data()), response.body->size()};
  }
};

Got ask(const Page& page, const std::string& path, const std::string& encoding = "", const std::string& tag = "") {
  Request request;
  request.method = "GET", request.path = path, request.accept_encoding = encoding, request.if_none_match = tag;
  Got got;
  got.ours = page.answer(request, [&](Response r) { got.response = std::move(r); });
  return got;
}

class PanelFolder : public testing::Test {
 protected:
  PanelFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "sinew-panels-XXXXXX").string();
    folder = mkdtemp(name.data());
    write("b.js", "export function mount() {}");
    write("a.js", "let a;");
    write("a.css", "p {}");
    write(".hidden.js", "no");
    write("notes.txt", "no");
  }
  ~PanelFolder() override { std::filesystem::remove_all(folder); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder / name) << text; }
  std::filesystem::path folder;
};

TEST(PageTest, IsInTheProgramWithItsScriptItsStyleAndItsLicences) {
  const Page page;
  const Got index = ask(page, "/");
  ASSERT_TRUE(index.ours);
  EXPECT_EQ(index.response.media_type, "text/html; charset=utf-8");
  EXPECT_THAT(index.body(), HasSubstr("/assets/page.js"));
  EXPECT_THAT(index.body(), HasSubstr("/assets/page.css"));
  EXPECT_EQ(ask(page, "/assets/page.js").response.media_type, "text/javascript; charset=utf-8");
  EXPECT_THAT(ask(page, "/licences.txt").body(), HasSubstr("preact"));
}

TEST(PageTest, HasNoInlineScriptOrStyleThatItsPolicyWouldForbid) {
  const std::string index = ask(Page(), "/").body();
  EXPECT_EQ(index.find("<style"), std::string::npos);
  EXPECT_EQ(index.find("style="), std::string::npos);
  for (std::size_t at = index.find("<script"); at != std::string::npos; at = index.find("<script", at + 1))
    EXPECT_EQ(index.substr(at, index.find("</script>", at) - at).back(), '>') << "a script with text in it";
}

TEST(PageTest, LeavesOtherPathsToOthers) {
  const Page page;
  for (const char* path : {"/quad/images/camera.raw.jpg", "/assets", "/assets/", "/index.htm", "/api", "/panels"})
    EXPECT_FALSE(ask(page, path).ours) << path;
}

TEST(PageTest, IsSentPackedToThoseWhoUnpack) {
  const Page page;
  const Got plain = ask(page, "/assets/page.js"), packed = ask(page, "/assets/page.js", "br, gzip");
  EXPECT_EQ(plain.header("content-encoding"), "");
  EXPECT_EQ(packed.header("content-encoding"), "gzip");
  EXPECT_EQ(packed.header("vary"), "accept-encoding");
  ASSERT_GE(packed.body().size(), 2u);
  EXPECT_EQ(packed.body().substr(0, 2), "\x1f\x8b");
  EXPECT_LT(packed.body().size(), plain.body().size() / 2);
}

TEST(PageTest, TakesLessThan150kBInAll) {
  std::size_t bytes = 0;
  for (const PageFile& f : page_files()) bytes += f.gzip.size();
  EXPECT_LT(bytes, 150'000u);
}

TEST(PageTest, IsNotSentAgainToThoseWhoHaveIt) {
  const Page page;
  const Got first = ask(page, "/assets/page.css");
  ASSERT_NE(first.header("etag"), "");
  const Got second = ask(page, "/assets/page.css", "gzip", first.header("etag"));
  EXPECT_EQ(second.response.status, 304);
  EXPECT_FALSE(second.response.body);
  EXPECT_EQ(ask(page, "/assets/page.css", "", "\"another\"").response.status, 200);
}

TEST_F(PanelFolder, ListsItsPanelsAndServesWhatTheyBring) {
  const Page page(folder.string());
  EXPECT_THAT(page.panels(), ElementsAre("/panels/a.js", "/panels/b.js"));
  const Got script = ask(page, "/panels/b.js");
  EXPECT_EQ(script.response.media_type, "text/javascript; charset=utf-8");
  EXPECT_EQ(script.body(), "export function mount() {}");
  EXPECT_EQ(ask(page, "/panels/a.css").response.media_type, "text/css; charset=utf-8");
}

TEST_F(PanelFolder, IsReadAnewSoThatAChangeIsSeen) {
  const Page page(folder.string());
  write("a.js", "let b;");
  EXPECT_EQ(ask(page, "/panels/a.js").body(), "let b;");
  EXPECT_EQ(ask(page, "/panels/a.js").header("cache-control"), "no-store");
}

TEST_F(PanelFolder, GivesNothingElseAway) {
  const Page page(folder.string());
  std::filesystem::create_directories(folder / "sub.js");
  for (const char* path : {"/panels/", "/panels/c.js", "/panels/notes.txt", "/panels/.hidden.js", "/panels/sub.js",
                           "/panels/../a.js", "/panels/sub/a.js", "/panels/a.js/"}) {
    const Got got = ask(page, path);
    EXPECT_TRUE(got.ours);
    EXPECT_EQ(got.response.status, 404) << path;
  }
}

TEST(PageTest, WithoutAFolderOfPanelsSaysSo) {
  const Page page;
  EXPECT_THAT(page.panels(), testing::IsEmpty());
  EXPECT_THAT(ask(page, "/panels/a.js").body(), HasSubstr("--panels"));
}

}  // namespace
}  // namespace sinew::monitor::page_test
