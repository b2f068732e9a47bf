// docs/reference/modules.md and messages.md say what the modules and messages declare.
#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "apps/flight/robot_modules.hpp"
#include "apps/view/reference_text.hpp"
#include "source_dir.hpp"

namespace sinew::app::reference_pages_test {
namespace {

void expect_page(const std::string& name, const std::string& is) {
  const std::string path = test::source_dir() + "/docs/reference/" + name;
  if (std::getenv("SINEW_WRITE_DOCS")) std::ofstream(path) << is;
  std::ifstream in(path);
  std::istringstream now(is);
  for (std::string a, b; std::getline(now, a);) {
    b.clear();
    std::getline(in, b);
    ASSERT_EQ(a, b) << path << " differs from what is declared; SINEW_WRITE_DOCS=1 writes it";
  }
  std::string more;
  EXPECT_FALSE(std::getline(in, more)) << "and has nothing more: " << more;
}

TEST(ReferencePages, ModulesAreWhatTheyDeclare) { expect_page("modules.md", modules_page(robot_modules())); }
TEST(ReferencePages, MessagesAreWhatTheirDescriptionsSay) {
  expect_page("messages.md", messages_page(robot_modules()));
}

TEST(ReferencePages, TextAndJsonHaveEveryPortAndParameter) {
  const rt::ModuleTypes types = robot_modules();
  for (const std::string& name : types.names()) {
    const auto d = declaration_of(types, name);
    ASSERT_TRUE(d) << name;
    const auto json = module_json(name, *d);
    EXPECT_EQ(json["ports"].size(), d->ports.size());
    EXPECT_EQ(json["params"].size(), d->params.size());
    for (const auto& p : json["params"]) {
      EXPECT_NE(module_text(name, *d).find(p["name"].get<std::string>()), std::string::npos) << name;
      EXPECT_NE(p["doc"], "") << name << "." << p["name"] << ": what does it do? ParamOptions::doc says it";
    }
  }
  EXPECT_FALSE(declaration_of(types, "control::Nobody"));
}

}  // namespace
}  // namespace sinew::app::reference_pages_test
