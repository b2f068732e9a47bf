#include <algorithm>

#include "rt/graph.hpp"
#include "rt/parameters.hpp"

namespace sinew::rt {
namespace {

using PortKind = Declaration::PortKind;

constexpr std::uint32_t kImageHistory = 5, kEventHistory = 50, kMaxHistory = 4096;

class ModuleSetup final : public Setup {
 public:
  ModuleSetup(hal::Board& board, GraphModule& module, const std::vector<GraphTopic>& topics,
              std::vector<Problem>& problems)
      : board_(board), module_(module), topics_(topics), problems_(problems) {}
  hal::Board& board() override { return board_; }
  std::string_view module_name() const override { return module_.spec.name; }
  std::uint32_t image_pixels(const InputBase& input) const override {
    for (std::size_t p = 0; p < module_.topic.size(); ++p)
      if (module_.declaration.ports[p].input == &input && module_.topic[p] != kNone)
        return topics_[module_.topic[p]].image_pixels;
    return 0;
  }
  std::uint32_t image_bytes(const OutputBase& output) const override {
    for (std::size_t p = 0; p < module_.topic.size(); ++p)
      if (module_.declaration.ports[p].output == &output && module_.topic[p] != kNone)
        return topics_[module_.topic[p]].image_bytes;
    return 0;
  }
  void hold(const OutputBase& raw, std::uint32_t slots) override {
    for (std::size_t p = 0; p < module_.topic.size(); ++p) {
      const Declaration::Port& port = module_.declaration.ports[p];
      if (port.output != &raw) continue;
      if (port.kind != PortKind::raw && !module_.external)
        bug("only slots of raw topics can be held", module_.spec.name + "." + port.name);
      module_.held[p] = slots;
    }
  }
  hal::Status narrow(std::string_view param, ParamRange range) override {
    const Declaration::Param* p = find_param(module_.declaration, param);
    const std::string name = module_.spec.name + "." + std::string(param);
    if (!p) bug("a parameter that is not declared is narrowed", name);
    if (!std::holds_alternative<double*>(p->target) && !std::holds_alternative<std::int64_t*>(p->target))
      bug("only numbers can be narrowed", name);
    auto& narrowed = module_.narrowed[static_cast<std::size_t>(p - module_.declaration.params.data())];
    narrowed = within(*p, std::move(range));
    const ParamValue value = current(*p);
    if (accepts(*p, value, narrowed)) return {};
    const auto given = module_.spec.params.find(std::string(param));
    problems_.push_back({given == module_.spec.params.end() ? module_.spec.line : given->second.line,
                         "module." + module_.spec.name + ".params." + std::string(param), to_string(value),
                         allowed_values(*p, narrowed)});
    return hal::Error{hal::Errc::bad_argument, "parameter"};
  }
  void explain(std::string text) override {
    problems_.push_back({module_.spec.line, "module." + module_.spec.name, "not ready", std::move(text)});
  }

 private:
  hal::Board& board_;
  GraphModule& module_;
  const std::vector<GraphTopic>& topics_;
  std::vector<Problem>& problems_;
};

std::string words_of(const hal::Error& e) {
  return std::string(hal::to_string(e.code)) + ": " + e.where + (e.detail ? " " + std::to_string(e.detail) : "");
}

}  // namespace

hal::Status Graph::configure(hal::Board& board, const ConfigureOptions& options) {
  configure_problems_.clear();
  for (GraphModule& m : modules_)
    for (const auto& [name, value] : m.spec.params) assign(*find_param(m.declaration, name), value.value);
  mailboxes_.clear();
  for (std::size_t i = 0; i < threads_.size(); ++i) mailboxes_.push_back(std::make_unique<Mailbox>());

  hal::Status first;
  const auto fail = [&](const GraphModule& m, const hal::Error& e) {
    configure_problems_.push_back({m.spec.line, "module." + m.spec.name, "not ready", words_of(e)});
    if (first) first = e;
  };
  for (GraphModule& m : modules_) {
    m.held.assign(m.topic.size(), 0);
    m.narrowed.assign(m.declaration.params.size(), {});
    ModuleSetup setup(board, m, topics_, configure_problems_);
    const std::size_t before = configure_problems_.size();
    const auto configured = m.module->configure(setup);
    if (configured) continue;
    if (configure_problems_.size() == before) fail(m, configured.error());  // the module explained nothing itself
    if (first) first = configured.error();
  }
  for (const GraphThread& t : threads_) {
    if (t.spec.trigger != ThreadSpec::Trigger::device || modules_[t.device_module].driver->device()) continue;
    if (first)
      fail(modules_[t.device_module], {hal::Errc::not_supported, "trigger `device`: this module has no device"});
  }
  if (!first) return first;
  if (auto made = make_segment(options); !made) return made;  // after the modules: now all held slots are known
  for (GraphModule& m : modules_) m.module->reset();
  return {};
}

hal::Status Graph::make_plan(const ConfigureOptions& options) {
  segment_.reset();
  plan_ = std::make_unique<SegmentPlan>(SegmentOptions{.first_sequence = options.first_sequence});
  topic_ids_.assign(topics_.size(), kNone);
  output_writers_.assign(modules_.size(), kNone);
  raw_writers_.assign(modules_.size(), {});
  connections_.assign(modules_.size(), {});
  for (std::uint32_t m = 0; m < modules_.size(); ++m) plan_outputs(m);
  for (std::uint32_t m = 0; m < modules_.size(); ++m) plan_inputs(m);
  taps_.clear();
  for (const std::string& name : options.taps) {
    const std::uint32_t topic = find_topic(name);
    if (topic == kNone) return hal::Error{hal::Errc::not_found, "tap"};
    taps_.push_back(plan_->connect(topic_ids_[topic], {}));
  }
  recorder_taps_.clear();
  if (options.recorded)
    for (const TopicId topic : topic_ids_) recorder_taps_.push_back(plan_->connect(topic, {}));
  return {};
}

hal::Status Graph::make_segment(const ConfigureOptions& options) {
  if (auto planned = make_plan(options); !planned) return planned;
  if (!options.os) {
    segment_ = std::make_unique<Segment>(*plan_);
    return {};
  }
  auto memory = options.os->shared_memory(spec_.robot.empty() ? "sinew" : spec_.robot, plan_->bytes());
  if (!memory) return memory.error();
  memory_ = std::move(*memory);
  segment_ = std::make_unique<Segment>(*plan_, *memory_);
  auto bells = OutsideBells::make(*options.os, segment_->header().writer_count);
  if (!bells) return bells.error();
  bells_ = std::move(*bells);
  return {};
}

double Graph::planned_rate_hz(std::uint32_t topic) const {
  const GraphModule& writer = modules_[topics_[topic].writer];
  const double steps_hz = thread_rates_hz()[writer.thread];
  const Duration usual = writer.declaration.ports[topics_[topic].port].usual_period;
  return usual > Duration{0} ? std::min(steps_hz, 1 / msg::seconds(usual)) : steps_hz;
}

std::vector<double> Graph::thread_rates_hz() const {
  std::vector<double> rates(threads_.size());
  for (std::size_t i = 0; i < threads_.size(); ++i)
    if (threads_[i].spec.trigger == ThreadSpec::Trigger::period) rates[i] = 1.0 / msg::seconds(threads_[i].spec.period);
  // A thread's rate is known when those of all its triggers are; every round finds one more, or none is left.
  for (std::size_t round = 0; round < threads_.size(); ++round)
    for (std::uint32_t i = 0; i < threads_.size(); ++i) {
      if (threads_[i].spec.trigger != ThreadSpec::Trigger::topics) continue;
      double sum = 0;
      bool known = true;
      for (const GraphTopic& topic : topics_) {
        if (std::find(topic.triggers.begin(), topic.triggers.end(), i) == topic.triggers.end()) continue;
        const std::uint32_t from = modules_[topic.writer].thread;
        const double rate = from == kNone || from == i ? 0 : rates[from];
        known &= rate > 0;
        sum += rate;
      }
      rates[i] = known && rates[i] == 0 ? sum : rates[i];
    }
  return rates;
}

std::uint32_t Graph::history_of(std::uint32_t index) const {
  const GraphTopic& topic = topics_[index];
  if (topic.history) return topic.history;
  if (spec_.tap_history <= Duration{0}) return 0;
  if (topic.type->has_bulk()) return kImageHistory;
  const double rate_hz = planned_rate_hz(index);
  if (rate_hz == 0) return kEventHistory;
  return static_cast<std::uint32_t>(std::min(rate_hz * msg::seconds(spec_.tap_history) + 1, double{kMaxHistory}));
}

void Graph::plan_outputs(std::uint32_t module) {
  const GraphModule& m = modules_[module];
  raw_writers_[module].assign(m.topic.size(), kNone);
  for (std::uint32_t p = 0; p < m.topic.size(); ++p) {
    const Declaration::Port& port = m.declaration.ports[p];
    if (port.kind != PortKind::output && port.kind != PortKind::raw) continue;
    const GraphTopic& topic = topics_[m.topic[p]];
    WriterId& writer = port.kind == PortKind::raw ? raw_writers_[module][p] : output_writers_[module];
    if (writer == kNone) writer = plan_->add_writer(port.kind == PortKind::raw ? topic.name : m.spec.name);
    TopicPlan plan;
    plan.name = topic.name;
    plan.type = topic.type;
    plan.bulk_bytes = topic.image_bytes;
    plan.burst = port.burst;
    plan.held = p < m.held.size() ? m.held[p] : 0;
    plan.history = history_of(m.topic[p]);
    plan.source_chains = topic.source_chains;
    topic_ids_[m.topic[p]] = plan_->add_topic(writer, std::move(plan));
  }
}

void Graph::plan_inputs(std::uint32_t module) {
  using Kind = ConnectionPlan::Kind;
  const GraphModule& m = modules_[module];
  connections_[module].assign(m.topic.size(), kNone);
  for (std::uint32_t p = 0; p < m.topic.size(); ++p) {
    const Declaration::Port& port = m.declaration.ports[p];
    if (port.kind == PortKind::output || m.topic[p] == kNone) continue;
    ConnectionPlan plan;
    plan.kind = port.overflow == Overflow::drop_oldest ? Kind::drop_oldest : Kind::drop_newest;
    if (port.kind == PortKind::latest) plan.kind = Kind::latest;
    plan.depth = port.depth;
    plan.same_thread = modules_[topics_[m.topic[p]].writer].thread == m.thread;
    connections_[module][p] = plan_->connect(topic_ids_[m.topic[p]], plan);
  }
}

}  // namespace sinew::rt
