// bag recover, cut, filter, merge: new files from existing ones.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "apps/bag/bag_options.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "record/copy.hpp"
#include "record/run/part.hpp"
#include "record/run/ros2_convert.hpp"
#include "record/run/run_messages.hpp"
#include "record/run/run_recorder.hpp"
#include "record/run/run_review.hpp"

namespace sinew::app {
namespace {

using Readers = std::vector<std::unique_ptr<record::Reader>>;

/// `said`: texts that mark the copy as edited; empty: the copy is not marked. `ros2`: convert to messages of ROS 2.
hal::Status write_copy(const Readers& readers, const record::Query& query, const record::CopyChanges& changes,
                       const record::Texts& said, bool ros2, std::unique_ptr<hal::OutputFile> out,
                       record::Copied& copied) {
  record::WriterOptions how = options_like(*readers.front());
  std::unique_ptr<record::Conversion> conversion;
  if (ros2) {
    how.profile = "ros2";
    conversion = record::to_ros2(record::unix_ns_of(*readers.front()));
  }
  auto writer = record::Writer::open(std::move(out), how);
  if (!writer) return writer.error();
  std::vector<record::Reader*> from;
  for (const auto& reader : readers) from.push_back(reader.get());
  if (auto done = record::copy(from, query, **writer, copied, conversion.get(), changes); !done) return done;
  if (!said.empty())
    if (auto done = (*writer)->add_metadata({std::string(record::kEditedName), said}); !done) return done;
  return (*writer)->finish();
}

int say(const BagCopyOptions& options, const record::Copied& copied) {
  say_problems(options.file.empty() ? "the files" : options.file, copied.problems);
  if (options.json) {
    Json problems = Json::array();
    for (const auto& p : copied.problems) problems.push_back(to_string(p));
    std::printf("%s", to_line({{"file", options.out},
                               {"messages", copied.messages},
                               {"attachments", copied.attachments},
                               {"metadata", copied.metadata},
                               {"problems", problems}})
                          .c_str());
  } else {
    std::printf("%s: %llu messages, %llu attachments, %llu metadata\n", options.out.c_str(),
                static_cast<unsigned long long>(copied.messages), static_cast<unsigned long long>(copied.attachments),
                static_cast<unsigned long long>(copied.metadata));
  }
  return kDone;
}

/// Adds the topics of the images' heads, which belong to the images.
void add_heads(record::Query& query) {
  const std::size_t topics = query.topics.size();
  for (std::size_t i = 0; i < topics; ++i) query.topics.push_back(query.topics[i] + std::string(record::kHeadSuffix));
}

/// Says at once what a part of a run is not good for: it begins with the states that happen to be in it.
void say_what_cannot_be_replayed(const std::string& path, Progress& progress) {
  const auto reader = open_recording(path, progress);
  if (!reader) return;
  const record::RunReview review = record::review(*reader);
  std::string names;
  std::size_t count = 0;
  for (const record::ModuleVerdict& module : review.verdict)
    if (std::ranges::any_of(module.reasons, [](const auto& why) { return why.starts_with("no saved state"); }))
      names += (count++ == 0 ? "" : ", ") + module.module;
  if (count > 0)
    std::fprintf(
        stderr,
        "%s: note: replay cannot execute %zu of %zu modules of this part, which has no saved state of theirs (one "
        "each every %lld s; take more than that, from an earlier --from): %s\n",
        path.c_str(), count, review.verdict.size(),
        static_cast<long long>(record::RecorderOptions().state_every / std::chrono::seconds(1)), names.c_str());
}

int make_copy(const BagCopyOptions& options, const char* what, const std::vector<std::string>& files,
              record::Texts said, bool ros2 = false) {
  record::Copied copied;
  {
    Progress progress(what);
    Readers readers;
    for (const std::string& file : files) {
      readers.push_back(open_recording(file, progress));
      if (!readers.back()) return kNotBegun;
    }
    std::vector<record::Reader*> from;
    for (const auto& reader : readers) from.push_back(reader.get());
    if (from.size() > 1)
      if (const auto why = record::topic_conflict(from)) return fail(*why + ": these files cannot be merged", kFailed);
    auto query = query_of(*readers.front(), options.what);
    if (!query) return kNotBegun;
    add_heads(*query);
    const record::CopyChanges changes =
        from.size() > 1 ? record::changes_of_merge(from) : record::changes_of_cut(*from.front(), query->from);
    auto out = create_output(options.out);
    if (!out) return kNotBegun;
    if (!said.empty()) {
      said["by"] = std::string("sinew bag ") + what;
      for (std::size_t i = 0; i < files.size(); ++i) said[fmt::format("of_{:03}", i)] = files[i];
    }
    if (const auto done = write_copy(readers, *query, changes, said, ros2, std::move(out), copied); !done) {
      std::error_code ignored;
      std::filesystem::remove(options.out, ignored);  // our own file, and incomplete
      return fail(file_error(options.out, done.error()), kFailed);
    }
    if (files.size() == 1 && !changes.metadata.empty()) say_what_cannot_be_replayed(options.out, progress);
  }
  return say(options, copied);
}

}  // namespace

int bag_recover(const BagCopyOptions& options) { return make_copy(options, "recover", {options.file}, {}); }

int bag_cut(const BagCopyOptions& options) {
  record::Texts said;
  if (options.what.from_s) said["from_s"] = fmt::format("{}", *options.what.from_s);
  if (options.what.until_s) said["until_s"] = fmt::format("{}", *options.what.until_s);
  if (said.empty()) return fail("cut: --from, --until or both say what shall stay");
  return make_copy(options, "cut", {options.file}, said);
}

int bag_filter(const BagCopyOptions& options) {
  std::string topics;
  for (const auto& topic : options.what.topics) topics += (topics.empty() ? "" : " ") + topic;
  return make_copy(options, "filter", {options.file}, {{"topics", topics}});
}

int bag_convert(const BagCopyOptions& options) {
  return make_copy(options, "convert", {options.file}, {{"to", "ros2"}}, options.ros2);
}

int bag_merge(const BagCopyOptions& options) {
  return make_copy(options, "merge", options.files, {{"files", std::to_string(options.files.size())}});
}

}  // namespace sinew::app
