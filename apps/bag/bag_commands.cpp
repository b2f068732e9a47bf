// bag: recorded files.
#include <CLI/CLI.hpp>

#include "apps/bag/bag_options.hpp"
#include "apps/bag/commands.hpp"
#include "apps/command/number_check.hpp"
#include "apps/view/plot.hpp"
#include "record/run/playback.hpp"

namespace sinew::app {
namespace {

template <class O>
struct BagCommand {
  CLI::App& app;
  O& options;
};

template <class O>
BagCommand<O> bag_command(CLI::App& bag, CommandContext& context, const char* name, const char* text,
                          int (*run)(const O&)) {
  const auto options = std::make_shared<O>();
  CLI::App& app = *bag.add_subcommand(name, text);
  app.add_flag("--json", options->json, "as JSON");
  app.callback([&context, options, run] { context.action = [options, run] { return run(*options); }; });
  return {app, *options};
}

template <class O>
BagCommand<O> file_command(CLI::App& bag, CommandContext& context, const char* name, const char* text,
                           int (*run)(const O&)) {
  auto command = bag_command(bag, context, name, text, run);
  command.app.add_option("file", command.options.file, "an MCAP file")->required()->type_name(kFileHint);
  return command;
}

void add_out(CLI::App& app, std::string& out) {
  app.add_option("out", out, "a new file")->required()->type_name(kFileHint);
}

CLI::Option* add_topics(CLI::App& app, Selection& what, const char* text) {
  return app.add_option("--topic", what.topics, text)->type_name(kTopicHint)->allow_extra_args(false);
}

/// `what`: a Selection, or options with the same two.
template <class W>
void add_times(CLI::App& app, W& what) {
  app.add_option("--from", what.from_s, "seconds after its first message")->check(number(0))->type_name("S");
  app.add_option("--until", what.until_s, "as --from; both ends are included")->check(number(0))->type_name("S");
}

}  // namespace

void add_bag_commands(CLI::App& app, CommandContext& context) {
  CLI::App& bag = *app.add_subcommand("bag", "recorded files");
  bag.require_subcommand(1);
  auto info = bag_command(bag, context, "info", "what is in it, what ran, what is missing", bag_info);
  info.app.add_option("files", info.options.files, "MCAP files")->required()->type_name(kFileHint);
  file_command(bag, context, "check", "check every checksum and index, and the summary against the content", bag_check);

  auto compare =
      file_command(bag, context, "compare", "two flights: events side by side, fields over time", bag_compare);
  compare.app.add_option("other", compare.options.other, "the MCAP file of the other flight")
      ->required()
      ->type_name(kFileHint);
  compare.app
      .add_option("--from-event", compare.options.from_event,
                  "where both times begin: \"climbing\", the name of a failsafe, \"start\" [climbing]")
      ->type_name("EVENT");
  compare.app.add_option("--field", compare.options.fields, "filter.state.p_world_m.z; may be given again")
      ->type_name(kFieldHint)
      ->allow_extra_args(false);
  compare.app.add_option("--plot", compare.options.plot, "draws them into a new FILE.svg or FILE.png")
      ->check(&why_no_plot_file)
      ->type_name(kFileHint);

  auto play = file_command(bag, context, "play",
                           "let a file stand up as a robot whose time can be paused, stepped and moved", bag_play);
  add_topics(play.app, play.options.what, "only this one; may be given again");
  add_times(play.app, play.options.what);
  play.app.add_option("--start-offset", play.options.what.from_s, "as --from, as ROS 2 names it")
      ->check(number(0))
      ->type_name("S")
      ->excludes("--from");
  play.app.add_option("--rate", play.options.rate, "recorded seconds per second")
      ->check(number(record::Playback::kSlowest, record::Playback::kFastest));
  play.app.add_option("--name", play.options.name, "name on this machine, instead of the recorded robot's");
  play.app.add_flag("--loop", play.options.loop, "again and again, until Ctrl-C");
  play.app.add_flag("--paused", play.options.paused, "begin in pause");
  play.app.add_flag("--stay", play.options.stay, "after the end of the file, too, until Ctrl-C");
  play.options.types = &context.types;

  auto cat = file_command(bag, context, "cat", "its messages, a line of JSON each", bag_cat);
  add_topics(cat.app, cat.options.what, "only this one; may be given again");
  add_times(cat.app, cat.options.what);
  cat.app.add_flag("--names", cat.options.names, "names in place of numbers, where the file has them");

  auto csv = file_command(bag, context, "csv", "the messages of one topic as a table", bag_csv);
  csv.app.add_option("out", csv.options.out, "a new file; else standard output")->type_name(kFileHint);
  add_topics(csv.app, csv.options.what, "which one")->required()->expected(1);
  add_times(csv.app, csv.options.what);
  csv.app.add_flag("--names", csv.options.names, "behind a number that has names a column FIELD_name");

  auto plot = file_command(bag, context, "plot", "fields over time, as SVG or PNG", bag_plot);
  add_plot_options(plot.app, plot.options.plot);
  add_times(plot.app, plot.options);

  auto images = file_command(bag, context, "images", "the images of one topic as PNG files", bag_images);
  images.app.add_option("folder", images.options.out, "where to")->required()->type_name(kFolderHint);
  add_topics(images.app, images.options.what, "which one")->required()->expected(1);
  add_times(images.app, images.options.what);

  auto recover =
      file_command(bag, context, "recover", "a complete file from the readable parts of a damaged one", bag_recover);
  add_out(recover.app, recover.options.out);
  auto cut = file_command(bag, context, "cut", "a file with a part of its time", bag_cut);
  add_out(cut.app, cut.options.out);
  add_times(cut.app, cut.options.what);
  auto filter = file_command(bag, context, "filter", "a file with some of its topics", bag_filter);
  add_out(filter.app, filter.options.out);
  add_topics(filter.app, filter.options.what, "this one; may be given again")->required();

  auto convert = file_command(bag, context, "convert", "a file for the programs of others", bag_convert);
  add_out(convert.app, convert.options.out);
  convert.app.add_flag("--ros2", convert.options.ros2, "messages that ROS 2 has, too, get its type")->required();

  auto merge = bag_command(bag, context, "merge", "one file of several, in the order of time", bag_merge);
  add_out(merge.app, merge.options.out);
  merge.app.add_option("files", merge.options.files, "MCAP files")->required()->expected(2, 1000)->type_name(kFileHint);
}

}  // namespace sinew::app
