// The contents of a file by our reader, in the words of others/read_all.mjs.
#include <cstdio>
#include <string>

#include "hal/linux/file.hpp"
#include "record/crc32.hpp"
#include "record/reader.hpp"

using namespace sinew;
using namespace sinew::record;

namespace {

using Ull = unsigned long long;

std::string texts(const Texts& map) {
  std::string out;
  for (const auto& [key, value] : map) out += (out.empty() ? "" : ",") + key + "=" + value;
  return out;
}

bool dump(const char* path) {
  auto file = hal::open_file(path);
  FileProblem why{ProblemKind::io, 0, "cannot be opened"};
  auto reader = file ? Reader::open(std::move(*file), why) : nullptr;
  if (!reader || !reader->by_summary() || !reader->problems().empty()) {
    std::printf("%s: %s\n", path,
                to_string(reader && !reader->problems().empty() ? reader->problems()[0] : why).c_str());
    return false;
  }
  std::printf("file %s\nheader %s|%s\n", path, reader->header().profile.c_str(), reader->header().library.c_str());
  for (const auto& [id, s] : reader->schemas())
    std::printf("schema %u %s %s %zu %08x\n", id, s.name.c_str(), s.encoding.c_str(), s.data.size(),
                crc32(as_bytes(s.data)));
  for (const auto& [id, c] : reader->channels())
    std::printf("channel %u %u %s %s %s\n", id, c.schema, c.topic.c_str(), c.message_encoding.c_str(),
                texts(c.metadata).c_str());
  bool good = true;
  for (const auto& index : reader->attachments()) {
    Attachment a;
    good = reader->read(index, a, why) && good;
    std::printf("attachment %llu %llu %s %s %zu %08x\n", Ull{a.log_time}, Ull{a.create_time}, a.name.c_str(),
                a.media_type.c_str(), a.data.size(), crc32(as_bytes(a.data)));
  }
  for (const auto& index : reader->metadata()) {
    Metadata m;
    good = reader->read(index, m, why) && good;
    std::printf("metadata %s %s\n", m.name.c_str(), texts(m.values).c_str());
  }
  if (const auto& s = reader->statistics()) {
    std::printf("statistics %llu %u %u %u %u %u %llu %llu ", Ull{s->messages}, s->schemas, s->channels, s->attachments,
                s->metadata, s->chunks, Ull{s->start_time}, Ull{s->end_time});
    const char* comma = "";
    for (const auto& [id, count] : s->channel_messages) std::printf("%s%u:%llu", comma, id, Ull{count}), comma = ",";
    std::printf("\n");
  }
  MessageReader messages = reader->messages();
  Message m;
  for (Next next; (next = messages.next(m)) != Next::end;) {
    if (next == Next::problem) good = false;
    if (next == Next::message)
      std::printf("message %u %u %llu %llu %zu %08x\n", m.channel->id, m.stamps.sequence, Ull{m.stamps.log_time},
                  Ull{m.stamps.publish_time}, m.data.size(), crc32(m.data));
  }
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  bool good = argc > 1;
  for (int i = 1; i < argc; ++i) good = dump(argv[i]) && good;
  return good ? 0 : 1;
}
