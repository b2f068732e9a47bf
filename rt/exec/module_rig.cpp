#include "rt/exec/module_rig.hpp"

#include <algorithm>
#include <cstring>

#include "rt/exec/runner.hpp"
#include "rt/parameters.hpp"

namespace sinew::rt {
namespace {

using PortKind = Declaration::PortKind;

constexpr const char* kModule = "rig::Module";

std::string source_of(const std::string& port) { return "in_" + port; }
std::string sink_of(const std::string& port) { return "out_" + port; }

[[noreturn]] void misuse(std::string_view where, const std::string& what) {
  bug(what, "module rig: " + std::string(where));
}

class NoDevices final : public hal::Board {
 public:
  hal::Result<hal::Device*> open_sensor(hal::SensorKind, std::string_view) override { return none(); }
  hal::Result<hal::Camera*> camera(std::string_view) override { return none(); }
  hal::Result<hal::Radio*> radio(std::string_view) override { return none(); }
  hal::Result<hal::Actuators*> actuators(std::string_view) override { return none(); }

 private:
  static hal::Error none() { return {hal::Errc::not_found, "module rig without a board"}; }
};

// The module under test inside of a graph that owns its modules. It is declared once, by the rig.
class Plain final : public Module {
 public:
  Plain(Module& module, const Declaration& declaration) : module_(module), declaration_(declaration) {}
  void declare(Declaration& d) override { d = declaration_; }
  hal::Status configure(Setup& setup) override { return module_.configure(setup); }
  void reset() override { module_.reset(); }
  StepStatus step(const Step& step) noexcept override { return module_.step(step); }

 private:
  Module& module_;
  const Declaration& declaration_;
};

class Driver final : public DriverModule {
 public:
  Driver(DriverModule& module, const Declaration& declaration) : module_(module), declaration_(declaration) {}
  void declare(Declaration& d) override { d = declaration_; }
  hal::Status configure(Setup& setup) override { return module_.configure(setup); }
  void reset() override { module_.reset(); }
  StepStatus step(const Step& step) noexcept override { return module_.step(step); }
  void collect(Time now) noexcept override { module_.collect(now); }
  void emit(Time now) noexcept override { module_.emit(now); }
  void rest(Time now) noexcept override { module_.rest(now); }
  void end() noexcept override { module_.end(); }
  hal::Device* device() override { return module_.device(); }

 private:
  DriverModule& module_;
  const Declaration& declaration_;
};

struct SourceOut : OutputBase {
  void* loan() { return claim(); }  // put() overwrites all of it
  msg::Image& loan_image() { return *fresh<msg::Image>(claim()); }
};

// Publishes what put() gives.
class Source final : public Module {
 public:
  explicit Source(const msg::TypeInfo& type) : type_(type) {}
  void declare(Declaration& d) override {
    d.ports.push_back({"message", PortKind::output, &type_, nullptr, &out_, 0, 1});
  }
  StepStatus step(const Step&) noexcept override {
    if (!type_.has_bulk()) std::memcpy(out_.loan(), next, type_.size);
    // Images are the only types with bulk that get here.
    else if (!msg::ImageBuffer::copy(*static_cast<const msg::Image*>(next), out_.loan_image()))
      return StepStatus::fault;
    return StepStatus::ok;
  }
  const void* next = nullptr;

 private:
  const msg::TypeInfo& type_;
  SourceOut out_;
};

// Holds what a step published, until the next step.
class Sink final : public Module {
 public:
  Sink(const Declaration::Port& of, const msg::TypeInfo& type) : of_(of), type_(type) {}
  void declare(Declaration& d) override {
    d.ports.push_back({"message", PortKind::queue, &type_, &in_, nullptr, of_.burst, 0});
  }
  StepStatus step(const Step&) noexcept override { return StepStatus::ok; }
  std::vector<const SlotHeader*> messages() const {
    std::vector<const SlotHeader*> all;
    for (std::size_t i = 0; i < in_.size(); ++i) all.push_back(in_.header(i));
    return all;
  }

 private:
  const Declaration::Port& of_;
  const msg::TypeInfo& type_;
  InputBase in_;
};

}  // namespace

class ModuleRig::Observer final : public RunObserver {
 public:
  void completed(const StepRecord& record) noexcept override { status = record.status; }
  StepStatus status = StepStatus::ok;
};

struct ModuleRig::Run {
  Run(GraphSpec spec, const ModuleTypes& types) : graph(std::move(spec), types) {}
  ModuleRunner& runner(std::uint32_t module) { return *runners[module]; }
  Module& module(const std::string& name) { return *graph.modules()[graph.find_module(name)].module; }

  NoDevices no_devices;
  Graph graph;
  Observer observer;
  std::unique_ptr<RunBoard> board;
  std::vector<std::unique_ptr<ModuleRunner>> runners;  // as the graph's modules
  std::vector<std::uint32_t> sinks;
  std::uint32_t subject = 0;
};

ModuleRig::ModuleRig(Module& module, RigOptions options) : module_(module), options_(std::move(options)) {
  module_.declare(declaration_);
}
ModuleRig::~ModuleRig() = default;

const Declaration::Port& ModuleRig::port(std::string_view name) const {
  std::string known;
  for (const auto& p : declaration_.ports) {
    if (p.name == name) return p;
    known += " " + p.name;
  }
  misuse(name, "no such port; there are:" + known);
}

void ModuleRig::leave_unbound(std::string_view input) {
  const Declaration::Port& p = port(input);
  if (run_) misuse(input, "leave_unbound() comes before the first put() or step()");
  if (!p.is_input() || !p.optional) misuse(input, "is no optional input");
  unbound_.push_back(p.name);
}

void ModuleRig::carries_erased(std::string_view name, const msg::TypeInfo& type) {
  if (port(name).type) misuse(name, "has a type: " + std::string(port(name).type->name));
  types_[std::string(name)] = &type;
}

const msg::TypeInfo& ModuleRig::type_of(const Declaration::Port& port) const {
  if (port.type) return *port.type;
  const auto given = types_.find(port.name);
  if (given == types_.end()) misuse(port.name, "has no type before carries<...>()");
  return *given->second;
}

void ModuleRig::image_capacity(std::string_view name, std::uint32_t bytes) {
  const Declaration::Port& p = port(name);
  if (run_) misuse(name, "image_capacity() comes before the first put() or step()");
  if (!type_of(p).has_bulk()) misuse(name, "carries " + std::string(type_of(p).name) + ", which has no pixels");
  image_bytes_[p.name] = bytes;
}

/// The module between a source for each input and a sink for each output, each in a thread of its own.
GraphSpec ModuleRig::spec() const {
  GraphSpec all;
  all.robot = "rig";
  all.seed = options_.seed;
  ModuleSpec subject;
  subject.name = options_.name;
  subject.type = kModule;
  const auto add = [&all](ModuleSpec m) {
    ThreadSpec t;
    t.name = m.name;
    t.order.push_back({m.name, 0});
    all.threads.push_back(std::move(t));
    all.modules.push_back(std::move(m));
  };
  for (const Declaration::Port& p : declaration_.ports) {
    if (p.is_input() && std::find(unbound_.begin(), unbound_.end(), p.name) != unbound_.end()) continue;
    const std::string topic = p.is_input() ? source_of(p.name) + ".message" : topic_name(options_.name, p.name);
    const auto bytes = image_bytes_.find(p.name);
    if (type_of(p).has_bulk())
      all.topics.push_back({topic, bytes == image_bytes_.end() ? options_.image_bytes : bytes->second, 0, 0});
    ModuleSpec end;
    end.name = end.type = p.is_input() ? source_of(p.name) : sink_of(p.name);
    if (p.is_input())
      subject.in[p.name] = {topic, 0};
    else
      end.in["message"] = {topic, 0};
    add(std::move(end));
  }
  add(std::move(subject));
  return all;
}

hal::Status ModuleRig::configure() {
  if (run_) misuse(options_.name, "is configured already");
  ModuleTypes types;
  types.add(kModule, [this]() -> std::unique_ptr<Module> {
    if (auto* driver = dynamic_cast<DriverModule*>(&module_)) return std::make_unique<Driver>(*driver, declaration_);
    return std::make_unique<Plain>(module_, declaration_);
  });
  for (const Declaration::Port& p : declaration_.ports) {
    if (std::find(unbound_.begin(), unbound_.end(), p.name) != unbound_.end()) continue;
    const msg::TypeInfo& type = type_of(p);
    if (p.is_input())
      types.add(source_of(p.name), [&type] { return std::make_unique<Source>(type); });
    else
      types.add(sink_of(p.name), [&p, &type] { return std::make_unique<Sink>(p, type); });
  }
  run_ = std::make_unique<Run>(spec(), types);
  Run& run = *run_;
  run.subject = run.graph.find_module(options_.name);
  ConfigureOptions options;
  options.first_sequence = options_.first_sequence;
  auto configured = run.graph.configure(options_.board ? *options_.board : run.no_devices, options);
  if (!configured) return configured;
  run.board = std::make_unique<RunBoard>(run.graph, RunnerOptions{Time{}, false, 0, &run.observer});
  for (std::uint32_t m = 0; m < run.graph.modules().size(); ++m) {
    run.runners.push_back(std::make_unique<ModuleRunner>(*run.board, m));
    if (dynamic_cast<Sink*>(run.graph.modules()[m].module.get())) run.sinks.push_back(m);
  }
  return {};
}

const std::vector<Problem>& ModuleRig::problems() const {
  if (!run_) misuse(options_.name, "is not configured yet");
  return run_->graph.configure_problems();
}

void ModuleRig::be_configured() {
  if (!run_ && !configure()) {
    std::string text;
    for (const Problem& p : run_->graph.configure_problems()) text += p.value + ": " + p.allowed + "; ";
    misuse(options_.name, text);
  }
  if (run_->runners.empty()) misuse(options_.name, "configure() has failed");
}

std::string ModuleRig::refusal(std::string_view name, const ParamValue& value) const {
  const Declaration::Param* p = find_param(declaration_, name);
  if (!p) misuse(name, "no such parameter");
  const auto index = static_cast<std::size_t>(p - declaration_.params.data());
  const std::optional<ParamRange> none, &narrowed = run_ ? run_->graph.modules()[run_->subject].narrowed[index] : none;
  return accepts(*p, value, narrowed) ? std::string() : allowed_values(*p, narrowed);
}

void ModuleRig::set(std::string_view name, const ParamValue& value) {
  if (const std::string allowed = refusal(name, value); !allowed.empty())
    misuse(name, to_string(value) + ": " + allowed);
  assign(*find_param(declaration_, name), value);
}

void ModuleRig::put_erased(std::string_view input, const msg::TypeInfo& type, const void* message,
                           std::optional<Time> published) {
  const Declaration::Port& p = port(input);
  if (!p.is_input()) misuse(input, "is an output");
  if (&type_of(p) != &type) misuse(input, "takes " + std::string(type_of(p).name) + ", not " + std::string(type.name));
  be_configured();
  const std::uint32_t source = run_->graph.find_module(source_of(p.name));
  if (source == kNone) misuse(input, "was left unbound");
  static_cast<Source&>(*run_->graph.modules()[source].module).next = message;
  const Time now = published.value_or(now_);
  run_->runner(source).start({now, Duration{1}, false}, now);
  run_->runner(source).complete(now, Duration{0});
  if (run_->observer.status != StepStatus::ok) misuse(input, "the image does not fit; give image_capacity()");
}

StepStatus ModuleRig::step(Time now, Duration dt, bool timed_out) {
  if (dt <= Duration{0}) misuse(options_.name, "dt is not above 0");
  be_configured();
  Run& run = *run_;
  now_ = now;
  if (!run.runner(run.subject).runs()) run.runner(run.subject).set_enabled(true);  // after rest()
  const Cycle cycle{now, dt, timed_out};
  for (const std::uint32_t sink : run.sinks) run.runner(sink).complete(now, Duration{0});  // releases the last step's
  run.runner(run.subject).start(cycle, now);
  run.runner(run.subject).complete(now, Duration{0});
  const StepStatus status = run.observer.status;
  for (const std::uint32_t sink : run.sinks) run.runner(sink).start(cycle, now);
  return status;
}

void ModuleRig::rest(Time now) {
  be_configured();
  Run& run = *run_;
  now_ = now;
  ModuleRunner& subject = run.runner(run.subject);
  for (const std::uint32_t sink : run.sinks) run.runner(sink).complete(now, Duration{0});
  subject.set_enabled(false);
  subject.start({now, Duration{1}, false}, now);
  subject.complete(now, Duration{0});
  for (const std::uint32_t sink : run.sinks) run.runner(sink).start({now, Duration{1}, false}, now);
}

void ModuleRig::reset() {
  be_configured();
  run_->runner(run_->subject).set_enabled(false);
  run_->runner(run_->subject).set_enabled(true);
}

std::vector<const SlotHeader*> ModuleRig::published(std::string_view output, const msg::TypeInfo& type) const {
  const Declaration::Port& p = port(output);
  if (&type_of(p) != &type) misuse(output, "gives " + std::string(type_of(p).name) + ", not " + std::string(type.name));
  return headers(output);
}

std::vector<const SlotHeader*> ModuleRig::headers(std::string_view output) const {
  const Declaration::Port& p = port(output);
  if (p.is_input()) misuse(output, "is an input");
  if (!run_ || run_->runners.empty()) return {};
  return static_cast<const Sink&>(run_->module(sink_of(p.name))).messages();
}

const ModuleStats& ModuleRig::stats() const {
  if (!run_ || run_->runners.empty()) misuse(options_.name, "is not configured yet");
  return run_->runner(run_->subject).stats();
}

}  // namespace sinew::rt
