// new, completion: commands without a robot.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/command/place.hpp"
#include "apps/completion.hpp"
#include "apps/new_project.hpp"
#include "apps/project_commands.hpp"

namespace sinew::app {
namespace {

struct NewOptions {
  std::string name, folder;
};

int new_project(const NewOptions& options) {
  if (const auto why = refuse_project_name(options.name); !why.empty()) return fail(why);
  const std::string folder = options.folder.empty() ? options.name : options.folder;
  if (const auto why = write_project(options.name, folder, package_folder()); !why.empty()) return fail(why, kFailed);
  std::printf("%s: a module, its test, a robot file. Next:\n", folder.c_str());
  std::printf("  cd %s && cmake -B build && cmake --build build && ./build/%s run %s.toml --virtual\n", folder.c_str(),
              options.name.c_str(), options.name.c_str());
  return kDone;
}

}  // namespace

void add_project_commands(CLI::App& app, CommandContext& context) {
  const auto new_options = std::make_shared<NewOptions>();
  CLI::App* make = app.add_subcommand("new", "write a project of your own that builds and runs");
  make->add_option("name", new_options->name, "a-z, 0-9 and _")->required();
  make->add_option("folder", new_options->folder, "default: the name")->type_name(kFolderHint);
  make->callback([&context, new_options] { context.action = [new_options] { return new_project(*new_options); }; });

  const auto shell = std::make_shared<std::string>();
  CLI::App* completion =
      app.add_subcommand("completion", "print a script for the shell: source <(sinew completion bash)");
  completion->add_option("shell", *shell, "bash")->required()->check(CLI::IsMember({"bash"}));
  completion->callback([&app, &context, shell] {
    context.action = [program = app.get_name()] {
      std::printf("%s", bash_completion(program).c_str());
      return kDone;
    };
  });
}

}  // namespace sinew::app
