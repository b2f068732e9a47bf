#include <algorithm>

#include "record/reader.hpp"

namespace sinew::record {

/// Blocks are opened in the order of `plan`; the open ones wait in a heap, the earliest message on top.
struct MessageReader::State {
  Reader& reader;
  Query query;
  std::vector<bool> wanted;       // by channel
  std::vector<std::size_t> plan;  // blocks, as they will be opened
  std::size_t planned = 0;

  struct Open {
    std::size_t block = 0, at = 0;
    std::vector<ChunkContents::Entry> entries;  // the wanted ones, in the order in which they go out
    ChunkContents contents;
    const ChunkContents::Entry& top() const { return entries[at]; }
  };
  std::vector<std::unique_ptr<Open>> heap, spare;
  std::uint64_t open_bytes = 0;
  bool advance = false;  // the message on top has been handed out
  bool cut_told = false;
  FileProblem problem;
  Decompressor decompressor;

  State(Reader& r, Query q) : reader(r), query(std::move(q)), wanted(65536, query.topics.empty()) {
    for (const auto& [id, channel] : reader.channels()) want(channel);
  }

  void want(const Channel& channel) {
    if (std::find(query.topics.begin(), query.topics.end(), channel.topic) != query.topics.end())
      wanted[channel.id] = true;
  }

  bool by_time() const { return query.order == Order::log_time; }
  /// True if b goes out before a: the heap's order.
  bool later(const Open& a, const Open& b) const {
    if (by_time() && a.top().log_time != b.top().log_time) return a.top().log_time > b.top().log_time;
    return a.block > b.block;
  }
  auto order() const {
    return [this](const auto& a, const auto& b) { return later(*a, *b); };
  }

  bool concerns(const Block& block) const {
    if (block.end_time < query.from || block.start_time > query.until) return false;
    return block.channels.empty() ||
           std::any_of(block.channels.begin(), block.channels.end(), [this](auto id) { return wanted[id]; });
  }

  void start() {
    for (auto& open : heap) spare.push_back(std::move(open));
    heap.clear(), plan.clear();
    planned = 0, open_bytes = 0, advance = false, cut_told = false;
    const auto& blocks = reader.blocks_;
    for (std::size_t i = 0; i < blocks.size(); ++i)
      if (concerns(blocks[i])) plan.push_back(i);
    if (by_time())
      std::stable_sort(plan.begin(), plan.end(),
                       [&](auto a, auto b) { return blocks[a].start_time < blocks[b].start_time; });
  }

  /// True if the next planned block may hold a message that goes out before the one on top.
  bool must_open() const {
    if (planned == plan.size()) return false;
    if (heap.empty()) return true;
    return by_time() && reader.blocks_[plan[planned]].start_time <= heap.front()->top().log_time;
  }

  /// False: there is a problem to report.
  bool open_next() {
    const std::size_t index = plan[planned++];
    const Block& block = reader.blocks_[index];
    auto open = spare.empty() ? std::make_unique<Open>() : std::move(spare.back());
    if (!spare.empty()) spare.pop_back();
    open->block = index, open->at = 0;
    open->entries.clear();
    ChunkContents& contents = open->contents;
    bool good = contents.load(*reader.file_, block, reader.limits_, decompressor, problem);
    if (good) good = merge_definitions(contents.schemas(), contents.channels(), block.offset, reader.summary_, problem);
    if (good && open_bytes + contents.records().size() > reader.limits_.open_bytes && !heap.empty()) {
      problem = {ProblemKind::too_large, block.offset,
                 "too many chunks overlap in log time; read them in the order of the file"};
      good = false;
    }
    if (!good) {
      spare.push_back(std::move(open));
      return false;
    }
    for (const Channel& channel : contents.channels()) want(channel);  // the summary need not have it
    const bool known = choose(*open, block);
    if (open->entries.empty()) {
      spare.push_back(std::move(open));
    } else {
      open_bytes += contents.records().size();
      heap.push_back(std::move(open));
      std::push_heap(heap.begin(), heap.end(), order());
    }
    return known;
  }

  /// Chooses the messages that the query asks for. False: some belong to an unknown channel.
  bool choose(Open& open, const Block& block) {
    std::uint64_t unknown = 0;
    for (const auto& entry : open.contents.entries()) {
      if (entry.log_time < query.from || entry.log_time > query.until) continue;
      if (!reader.summary_.channels.contains(entry.channel))
        ++unknown;
      else if (wanted[entry.channel])
        open.entries.push_back(entry);
    }
    const auto earlier = [](const auto& a, const auto& b) { return a.log_time < b.log_time; };
    if (by_time() && !std::is_sorted(open.entries.begin(), open.entries.end(), earlier))
      std::stable_sort(open.entries.begin(), open.entries.end(), earlier);
    if (unknown != 0)
      problem = {ProblemKind::unknown_channel, block.offset,
                 std::to_string(unknown) + " messages are of channels that were not defined before"};
    return unknown == 0;
  }

  void drop_top() {
    advance = false;
    std::pop_heap(heap.begin(), heap.end(), order());
    auto& last = heap.back();
    if (++last->at < last->entries.size()) {
      std::push_heap(heap.begin(), heap.end(), order());
      return;
    }
    open_bytes -= last->contents.records().size();
    spare.push_back(std::move(last));
    heap.pop_back();
  }

  Next next(Message& message) {
    if (advance) drop_top();
    while (must_open())
      if (!open_next()) return Next::problem;
    if (heap.empty()) {
      if (!reader.cut_ || cut_told) return Next::end;
      cut_told = true, problem = *reader.cut_;
      return Next::problem;
    }
    const Open& top = *heap.front();
    message.channel = &reader.summary_.channels.at(top.top().channel);
    top.contents.message(top.top(), message.stamps, message.data);
    advance = true;
    return Next::message;
  }
};

MessageReader::MessageReader(Reader& reader, Query query) : state_(std::make_unique<State>(reader, std::move(query))) {
  state_->start();
}
MessageReader::~MessageReader() = default;
MessageReader::MessageReader(MessageReader&&) noexcept = default;

Next MessageReader::next(Message& message) { return state_->next(message); }
const FileProblem& MessageReader::problem() const { return state_->problem; }
void MessageReader::seek(std::uint64_t log_time) {
  state_->query.from = log_time;
  state_->start();
}

}  // namespace sinew::record
