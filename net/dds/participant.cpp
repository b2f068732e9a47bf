#include "net/dds/participant.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <string_view>

#include "net/dds/config_xml.hpp"
#include "net/dds/dds_log.hpp"
#include "net/dds/raw_type.hpp"

namespace sinew::net {
namespace {

using hal::Errc;
using hal::Error;

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using OwnedQos = std::unique_ptr<dds_qos_t, QosDeleter>;

struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using OwnedListener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

/// An entity of Cyclone's; it ends with what it has inside.
class Entity {
 public:
  Entity() = default;
  explicit Entity(dds_entity_t id) : id_(id) {}
  Entity(Entity&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Entity() {
    if (id_ > 0) dds_delete(id_);
  }
  dds_entity_t id() const { return id_; }
  bool ok() const { return id_ > 0; }

 private:
  dds_entity_t id_ = 0;
};

class EventFd {
 public:
  EventFd() : fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
  ~EventFd() {
    if (fd_ >= 0) close(fd_);
  }
  EventFd(const EventFd&) = delete;
  EventFd& operator=(const EventFd&) = delete;
  void ring() const {
    const std::uint64_t one = 1;
    static_cast<void>(::write(fd_, &one, sizeof one));  // full: it is readable as it is
  }
  void clear() const {
    std::uint64_t count = 0;
    static_cast<void>(::read(fd_, &count, sizeof count));
  }
  int fd() const { return fd_; }

 private:
  int fd_;
};

void ring_event(void* event) { static_cast<const EventFd*>(event)->ring(); }

OwnedListener listener_that_rings(EventFd& event) {
  OwnedListener listener(dds_create_listener(&event));
  dds_lset_data_available(listener.get(), [](dds_entity_t, void* e) { ring_event(e); });
  dds_lset_publication_matched(listener.get(),
                               [](dds_entity_t, const dds_publication_matched_status_t, void* e) { ring_event(e); });
  dds_lset_subscription_matched(listener.get(),
                                [](dds_entity_t, const dds_subscription_matched_status_t, void* e) { ring_event(e); });
  return listener;
}

Guid guid_of(const dds_guid_t& from) {
  Guid out{};
  std::copy(std::begin(from.v), std::end(from.v), out.begin());
  return out;
}

Guid guid_of(dds_entity_t entity) {
  dds_guid_t guid{};
  return dds_get_guid(entity, &guid) == DDS_RETCODE_OK ? guid_of(guid) : Guid{};
}

OwnedQos cyclones_qos(const EndpointSpec& spec, bool writes) {
  const DdsQos& q = spec.qos;
  OwnedQos out(dds_create_qos());
  dds_qos_t* to = out.get();
  dds_qset_reliability(to, q.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, q.patience.count());
  dds_qset_durability(to, q.transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  const auto depth = static_cast<std::int32_t>(q.depth);
  dds_qset_history(to, q.depth == 0 ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST, q.depth == 0 ? 1 : depth);
  if (writes && q.transient_local)  // what a late reader gets
    dds_qset_durability_service(to, 0, q.depth == 0 ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST,
                                q.depth == 0 ? 1 : depth, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED);
  if (q.deadline.count() > 0) dds_qset_deadline(to, q.deadline.count());
  if (writes && q.lifespan.count() > 0) dds_qset_lifespan(to, q.lifespan.count());
  if (!q.partitions.empty()) {
    std::vector<const char*> names;
    for (const std::string& name : q.partitions) names.push_back(name.c_str());
    dds_qset_partition(to, static_cast<std::uint32_t>(names.size()), names.data());
  }
  const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(to, 1, &xcdr1);
  dds_qset_ignorelocal(to, DDS_IGNORELOCAL_PARTICIPANT);
  if (!spec.user_data.empty()) dds_qset_userdata(to, spec.user_data.data(), spec.user_data.size());
  return out;
}

std::string user_data_of(const dds_qos_t* qos) {
  void* data = nullptr;
  std::size_t size = 0;
  if (!dds_qget_userdata(qos, &data, &size) || data == nullptr) return {};
  std::string out(static_cast<const char*>(data), size);
  dds_free(data);
  return out;
}

Duration duration_of(dds_duration_t ns) { return ns == DDS_INFINITY ? Duration{} : Duration{ns}; }

DdsQos our_qos(const dds_qos_t* from) {
  DdsQos q;
  dds_reliability_kind_t reliability{};
  dds_durability_kind_t durability{};
  dds_history_kind_t history{};
  std::int32_t depth = 1;
  dds_duration_t time = 0;
  if (dds_qget_reliability(from, &reliability, &time)) q.reliable = reliability == DDS_RELIABILITY_RELIABLE;
  if (dds_qget_durability(from, &durability)) q.transient_local = durability >= DDS_DURABILITY_TRANSIENT_LOCAL;
  if (dds_qget_history(from, &history, &depth))
    q.depth = history == DDS_HISTORY_KEEP_ALL ? 0 : static_cast<std::uint32_t>(depth);
  if (dds_qget_deadline(from, &time)) q.deadline = duration_of(time);
  if (dds_qget_lifespan(from, &time)) q.lifespan = duration_of(time);
  std::uint32_t count = 0;
  char** names = nullptr;
  if (dds_qget_partition(from, &count, &names)) {
    for (std::uint32_t i = 0; i < count; ++i) {
      q.partitions.emplace_back(names[i]);
      dds_free(names[i]);
    }
    dds_free(names);
  }
  return q;
}

bool takes_xcdr1(const dds_qos_t* qos) {
  std::uint32_t count = 0;
  dds_data_representation_id_t* kinds = nullptr;
  if (!dds_qget_data_representation(qos, &count, &kinds)) return true;  // says nothing: XCDR1 (XTypes 7.6.3.1.1)
  const bool takes = count == 0 || std::find(kinds, kinds + count, DDS_DATA_REPRESENTATION_XCDR1) != kinds + count;
  dds_free(kinds);
  return takes;
}

/// All that a reader of Cyclone's builtin topics knows to be there.
template <class T, class Use>
void for_each_alive(dds_entity_t reader, const Use& use) {
  constexpr std::uint32_t kMask = DDS_ANY_SAMPLE_STATE | DDS_ANY_VIEW_STATE | DDS_ALIVE_INSTANCE_STATE;
  for (std::uint32_t most = 256;; most *= 4) {
    std::vector<void*> samples(most, nullptr);
    std::vector<dds_sample_info_t> infos(most);
    const dds_return_t count = dds_read_mask(reader, samples.data(), infos.data(), most, most, kMask);
    if (count < 0) return;
    if (static_cast<std::uint32_t>(count) < most || most > 200'000)
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
        if (infos[i].valid_data) use(*static_cast<const T*>(samples[i]));
    dds_return_loan(reader, samples.data(), count);
    if (static_cast<std::uint32_t>(count) < most || most > 200'000) return;
  }
}

class CycloneWriter final : public DdsWriter {
 public:
  CycloneWriter(Entity topic, Entity writer, const ddsi_sertype* type)
      : topic_(std::move(topic)), writer_(std::move(writer)), type_(type) {}
  hal::Status write(std::span<const std::uint8_t> cdr) override {
    if (cdr.size() < 4) return Error{Errc::bad_argument, "CDR without its head"};
    const dds_return_t result = dds_writecdr(writer_.id(), make_raw_sample(type_, cdr));
    if (result == DDS_RETCODE_OK) return {};
    return Error{result == DDS_RETCODE_TIMEOUT ? Errc::busy : Errc::io, "dds_writecdr", result};
  }
  std::uint32_t matched() const override {
    return static_cast<std::uint32_t>(std::max(0, dds_get_matched_subscriptions(writer_.id(), nullptr, 0)));
  }
  Guid guid() const override { return guid_of(writer_.id()); }

 private:
  Entity topic_, writer_;  // ends from the last to the first
  const ddsi_sertype* type_;
};

class CycloneReader final : public DdsReader {
 public:
  CycloneReader(Entity topic, Entity reader) : topic_(std::move(topic)), reader_(std::move(reader)) {}
  bool take(DdsSample& out) override {
    for (;;) {
      ddsi_serdata* data = nullptr;
      dds_sample_info_t info{};
      if (dds_takecdr(reader_.id(), &data, 1, &info, DDS_ANY_STATE) != 1) return false;
      const auto* sample = static_cast<const RawSample*>(data);
      const bool is_data = info.valid_data && sample->kind == SDK_DATA && sample->size >= 4;
      if (is_data) {
        out.cdr.assign(sample->cdr.begin(), sample->cdr.begin() + static_cast<std::ptrdiff_t>(sample->size));
        out.written_wall_ns = info.source_timestamp;
        out.writer = writer_of(info.publication_handle);
      }
      ddsi_serdata_unref(data);
      if (is_data) return true;  // the others say that a writer ended
    }
  }
  std::uint32_t matched() const override {
    return static_cast<std::uint32_t>(std::max(0, dds_get_matched_publications(reader_.id(), nullptr, 0)));
  }
  std::uint64_t lost() const override {
    dds_sample_lost_status_t status{};
    return dds_get_sample_lost_status(reader_.id(), &status) == DDS_RETCODE_OK ? status.total_count : 0;
  }
  Guid guid() const override { return guid_of(reader_.id()); }

 private:
  Guid writer_of(dds_instance_handle_t handle) {
    if (const auto known = writers_.find(handle); known != writers_.end()) return known->second;
    dds_builtintopic_endpoint_t* endpoint = dds_get_matched_publication_data(reader_.id(), handle);
    if (endpoint == nullptr) return {};
    const Guid guid = guid_of(endpoint->key);
    dds_builtintopic_free_endpoint(endpoint);
    if (writers_.size() >= kMostKnownWriters) writers_.clear();
    return writers_.emplace(handle, guid).first->second;
  }

  static constexpr std::size_t kMostKnownWriters = 1024;
  Entity topic_, reader_;
  std::map<dds_instance_handle_t, Guid> writers_;  // Cyclone's numbers of them are never used again
};

class CycloneParticipant final : public Participant {
 public:
  hal::Status open(const ParticipantOptions& options, std::string& why);

  hal::Result<std::unique_ptr<DdsWriter>> write(const EndpointSpec& spec, std::string& why) override {
    Entity topic;
    ddsi_sertype* type = nullptr;
    if (auto ok = make_topic(spec, topic, type, why); !ok) return ok.error();
    const OwnedQos qos = cyclones_qos(spec, true);
    const OwnedListener listener = listener_that_rings(event_);
    Entity writer(dds_create_writer(participant_.id(), topic.id(), qos.get(), listener.get()));
    if (!writer.ok()) return refused(writer.id(), "a writer of " + spec.topic, why);
    return std::unique_ptr<DdsWriter>(new CycloneWriter(std::move(topic), std::move(writer), type));
  }

  hal::Result<std::unique_ptr<DdsReader>> read(const EndpointSpec& spec, std::string& why) override {
    Entity topic;
    ddsi_sertype* type = nullptr;
    if (auto ok = make_topic(spec, topic, type, why); !ok) return ok.error();
    const OwnedQos qos = cyclones_qos(spec, false);
    const OwnedListener listener = listener_that_rings(event_);
    Entity reader(dds_create_reader(participant_.id(), topic.id(), qos.get(), listener.get()));
    if (!reader.ok()) return refused(reader.id(), "a reader of " + spec.topic, why);
    return std::unique_ptr<DdsReader>(new CycloneReader(std::move(topic), std::move(reader)));
  }

  int wake_fd() const override { return event_.fd(); }
  void begin_look() override { event_.clear(); }
  Guid guid() const override { return guid_of(participant_.id()); }
  std::vector<RemoteEndpoint> endpoints() override;
  std::vector<RemoteParticipant> participants() override;

 private:
  hal::Status make_topic(const EndpointSpec& spec, Entity& topic, ddsi_sertype*& type, std::string& why);
  static Error refused(dds_return_t code, const std::string& what, std::string& why);

  EventFd event_;  // the last to end: listeners ring it
  Entity domain_, participant_, seen_participants_, seen_writers_, seen_readers_;
};

std::string joined(const std::vector<std::string>& lines) {
  std::string out;
  for (const std::string& line : lines) out += (out.empty() ? "" : "; ") + line;
  return out;
}

Error CycloneParticipant::refused(dds_return_t code, const std::string& what, std::string& why) {
  const std::string said = joined(take_dds_log());
  why = what + ": " + (said.empty() ? dds_strretcode(code) : said);
  const auto says = [&](std::string_view words) { return said.find(words) != std::string::npos; };
  const Errc kind = says("participant index")                                          ? Errc::busy
                    : says("nterface")                                                 ? Errc::not_found
                    : says("ecurity") || code == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY   ? Errc::denied
                    : code == DDS_RETCODE_ERROR && (says("bind") || says("multicast")) ? Errc::io
                    : code == DDS_RETCODE_OUT_OF_RESOURCES                             ? Errc::io
                                                                                       : Errc::bad_argument;
  return Error{kind, "DDS", code};
}

hal::Status CycloneParticipant::open(const ParticipantOptions& options, std::string& why) {
  why = problem_of(options);
  if (!why.empty()) return Error{Errc::bad_argument, "DDS"};
  if (event_.fd() < 0) {
    why = "no eventfd";
    return Error{Errc::io, "eventfd", errno};
  }
  keep_dds_log();
  static_cast<void>(take_dds_log());
  // Cyclone's own number of the domain, which is only this process's; ExternalDomainId has the real one.
  static std::atomic<std::uint32_t> next{0};
  const std::uint32_t number = next.fetch_add(1, std::memory_order_relaxed);
  const std::string domain = "DDS domain " + std::to_string(options.domain);
  domain_ = Entity(dds_create_domain(number, config_xml(options).c_str()));
  if (!domain_.ok()) return refused(domain_.id(), domain, why);
  OwnedQos qos(dds_create_qos());
  if (!options.user_data.empty()) dds_qset_userdata(qos.get(), options.user_data.data(), options.user_data.size());
  participant_ = Entity(dds_create_participant(number, qos.get(), nullptr));
  if (!participant_.ok()) return refused(participant_.id(), domain, why);
  const OwnedListener listener = listener_that_rings(event_);
  for (const auto& [reader, topic] : {std::pair{&seen_participants_, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT},
                                      {&seen_writers_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION},
                                      {&seen_readers_, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION}}) {
    *reader = Entity(dds_create_reader(participant_.id(), topic, nullptr, listener.get()));
    if (!reader->ok()) return refused(reader->id(), domain, why);
  }
  return {};
}

hal::Status CycloneParticipant::make_topic(const EndpointSpec& spec, Entity& topic, ddsi_sertype*& type,
                                           std::string& why) {
  constexpr std::uint32_t kMostDepth = 100'000;
  why.clear();
  if (spec.topic.empty() || spec.type.empty()) why = "an endpoint without a topic or a type";
  if (spec.qos.depth > kMostDepth) why = spec.topic + ": depth is at most " + std::to_string(kMostDepth);
  if (!why.empty()) return Error{Errc::bad_argument, "DDS"};
  type = make_raw_type(spec.type);
  topic = Entity(dds_create_topic_sertype(participant_.id(), spec.topic.c_str(), &type, nullptr, nullptr, nullptr));
  if (topic.ok()) return {};
  ddsi_sertype_unref(type);
  return refused(topic.id(), "topic " + spec.topic, why);
}

std::vector<RemoteEndpoint> CycloneParticipant::endpoints() {
  std::vector<RemoteEndpoint> all;
  const Guid own = guid();
  for (const bool writes : {true, false})
    for_each_alive<dds_builtintopic_endpoint_t>(
        writes ? seen_writers_.id() : seen_readers_.id(), [&](const dds_builtintopic_endpoint_t& e) {
          if (guid_of(e.participant_key) == own) return;
          RemoteEndpoint& one = all.emplace_back();
          one.guid = guid_of(e.key), one.participant = guid_of(e.participant_key);
          one.writes = writes;
          one.topic = e.topic_name, one.type = e.type_name;
          one.qos = our_qos(e.qos);
          one.xcdr1 = takes_xcdr1(e.qos);
          one.user_data = user_data_of(e.qos);
        });
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.guid < b.guid; });
  return all;
}

std::vector<RemoteParticipant> CycloneParticipant::participants() {
  std::vector<RemoteParticipant> all;
  const Guid own = guid();
  for_each_alive<dds_builtintopic_participant_t>(seen_participants_.id(), [&](const dds_builtintopic_participant_t& p) {
    if (guid_of(p.key) != own) all.push_back({guid_of(p.key), user_data_of(p.qos)});
  });
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.guid < b.guid; });
  return all;
}

}  // namespace

std::string to_text(const Guid& guid) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string out;
  for (std::size_t i = 0; i < guid.size(); ++i) {
    if (i > 0 && i % 4 == 0) out += '.';
    out += kDigits[guid[i] >> 4];
    out += kDigits[guid[i] & 15];
  }
  return out;
}

hal::Result<std::unique_ptr<Participant>> Participant::open(const ParticipantOptions& options, std::string& why) {
  auto participant = std::make_unique<CycloneParticipant>();
  if (auto ok = participant->open(options, why); !ok) return ok.error();
  return std::unique_ptr<Participant>(std::move(participant));
}

}  // namespace sinew::net
