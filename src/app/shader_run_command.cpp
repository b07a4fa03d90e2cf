// `kinora shader run`: runs a shader group over a grid of points, slice by slice on several threads, prints what the
// points have to say in their order and writes outputs as pictures. Nothing that it prints or writes depends on the
// number of threads or on the width.
#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <deque>
#include <filesystem>

#include "app/command_line.h"
#include "app/exit_codes.h"
#include "app/shader_run.h"
#include "image/read_write.h"
#include "language/library/color_system.h"
#include "language/library/dictionary.h"

namespace kinora::app {

using language::Base;
using language::MessageKind;

namespace {

namespace fs = std::filesystem;

constexpr uint32_t kSlicePoints = 1024, kSlices = 64;      // at once
constexpr uint64_t kMostPictureBytes = uint64_t(8) << 30;  // of one output

struct Spoken {
  uint32_t point;  // within the slice
  MessageKind kind;
  std::string text, file;
};

// Standard output, standard error and the files that fprintf names, in the order of points.
class Speaker {
 public:
  explicit Speaker(const RunJob& job) : repeats_(job.option("error_repeats", 0) != 0) {}
  void say(const Spoken& s) {
    switch (s.kind) {
      case MessageKind::Printf:
        std::fwrite(s.text.data(), 1, s.text.size(), stdout);
        break;
      case MessageKind::Error:
        if (isNew(errors_, s.text)) toError("ERROR: ", s.text);
        break;
      case MessageKind::Warning:
        if (warnings_ < 100 && isNew(recentWarnings_, s.text)) ++warnings_, toError("WARNING: ", s.text);
        break;
      case MessageKind::File:
        append(s.file, s.text);
        break;
    }
  }
  bool hasFailed() const { return hasFailed_; }

 private:
  // A message that is like one of the last 32 is not told again.
  bool isNew(std::deque<std::string>& last, const std::string& text) {
    if (repeats_) return true;
    if (std::find(last.begin(), last.end(), text) != last.end()) return false;
    last.push_back(text);
    if (last.size() > 32) last.pop_front();
    return true;
  }
  void toError(const char* prefix, const std::string& text) {
    std::fflush(stdout);
    fmt::print(stderr, "{}{}\n", prefix, text);
  }
  // Only below the working directory: a shader may come from anywhere.
  void append(const std::string& name, const std::string& text) {
    if (refused_.count(name)) return;
    std::error_code ignored;
    const fs::path here = fs::canonical(".", ignored), file = fs::weakly_canonical(here / name, ignored);
    const auto [end, nothing] = std::mismatch(here.begin(), here.end(), file.begin(), file.end());
    const bool isInside = !name.empty() && end == here.end() && file != here;
    std::FILE* f = isInside ? std::fopen(file.c_str(), "ab") : nullptr;
    bool isWritten = f && std::fwrite(text.data(), 1, text.size(), f) == text.size();
    if (f) isWritten &= std::fclose(f) == 0;
    if (isWritten) return;
    refused_.insert(name);
    hasFailed_ = true;
    toError("error: fprintf: ", isInside ? "cannot write '" + name + "'"
                                         : "'" + name + "' is not in the working directory: nothing is written");
  }

  const bool repeats_;
  std::deque<std::string> errors_, recentWarnings_;
  int warnings_ = 0;
  bool hasFailed_ = false;
  std::set<std::string> refused_;
};

// An output that was asked for and is there.
struct Wanted {
  size_t output;  // of the executable
  std::string name, file;
  Base base = Base::Float;
  uint32_t channels = 0;
  std::vector<float> pixels;  // empty: only printed
};

class Runner {
 public:
  Runner(const RunJob& job, RunGroup& run) : job_(job), run_(run), world_(job, run.userData), speaker_(job) {}

  int run() {
    findOutputs();
    const auto started = std::chrono::steady_clock::now();
    if (!compile()) return 1;
    for (const std::string& warning : code_->warnings()) tell("warning: ", warning);
    for (Wanted& w : wanted_) {
      const language::Output& o = code_->outputs()[w.output];
      w.base = o.type.base;
      w.channels = uint32_t(language::componentsOf(o.type.base)) * uint32_t(std::max(1, o.type.arrayLength));
      if (w.file == "null" || job_.printsOutputs) continue;
      if (job_.grid.points() * w.channels * 4 > kMostPictureBytes) {
        tell("error: ", fmt::format("output '{}' of {} channels is too large for {} points", w.name, w.channels,
                                    job_.grid.points()));
        return 1;
      }
      w.pixels.resize(job_.grid.points() * w.channels);
    }
    const auto compiled = std::chrono::steady_clock::now();
    for (int i = 0; i < job_.iterations; ++i) {
      iterate(i + 1 == job_.iterations);
      if (i + 1 < job_.iterations && !run_.reparams.empty() && i == 0) {
        if (!reparameter()) return 1;
      }
    }
    std::fflush(stdout);
    const auto ran = std::chrono::steady_clock::now();
    if (!job_.isQuiet && job_.outputs.empty()) fmt::print("\n");
    const int written = write();
    if (job_.hasStats) statistics(compiled - started, ran - compiled);
    if (written != kComplete) return written;
    return hasMissingOutput_ || speaker_.hasFailed() ? 1 : kComplete;
  }

 private:
  void tell(const char* prefix, const std::string& text) {
    std::fflush(stdout);
    fmt::print(stderr, "{}{}\n", prefix, text);
  }

  // Outputs are named "name" (of the last layer that has it) or "layer.name".
  void findOutputs() {
    std::vector<ShadeOutput> asked = job_.outputs;
    if (asked.empty()) asked.push_back({"Cout", "null"});
    for (const ShadeOutput& o : asked) {
      const language::Layer* found = nullptr;
      std::string variable = o.variable, closure;
      for (auto layer = run_.group.layers.rbegin(); layer != run_.group.layers.rend() && !found; ++layer)
        for (const std::string& name :
             {o.variable,
              o.variable.starts_with(layer->name + ".") ? o.variable.substr(layer->name.size() + 1) : ""}) {
          const language::SymbolId id = name.empty() ? language::kNone : layer->shader->find(name);
          if (id == language::kNone || found) continue;
          const language::Symbol& s = layer->shader->symbols[size_t(id)];
          if (s.kind != language::SymbolKind::OutputParam) continue;
          if (language::componentsOf(s.type.base) == 0 || s.type.base == Base::String) {
            closure = nameOf(s.type);
            continue;
          }
          found = &*layer;
          variable = name;
        }
      if (found) {
        if (!job_.isQuiet && o.file != "null" && !job_.printsOutputs)
          messages_ += fmt::format("Output {} to {}\n", o.variable, o.file);
        wanted_.push_back({run_.group.outputs.size(), variable, o.file, Base::Float, 0, {}});
        run_.group.outputs.push_back(found->name + "." + variable);
      } else if (!job_.outputs.empty() && o.file != "null") {
        hasMissingOutput_ = true;
        missing_.push_back(closure.empty()
                               ? fmt::format("no layer has an output '{}': {} is not written", o.variable, o.file)
                               : fmt::format("output '{}' is a {}: {} is not written", o.variable, closure, o.file));
      }
    }
    if (!job_.isQuiet) {
      fmt::print("{}", run_.connections);
      if (job_.isVerbose) {
        fmt::print("Shader group:\n---\n{}---\n\nShader group \"{}\" layers are:\n", serialised(run_),
                   run_.group.name);
        for (const language::Layer& l : run_.group.layers) fmt::print("    {}\n", l.name);
        fmt::print("\n");
      }
      if (!job_.outputs.empty()) fmt::print("\n");
      if (!job_.entries.empty()) {
        fmt::print("Entry layers:");
        for (const std::string& e : job_.entries) {
          size_t at = 0;
          while (at < run_.group.layers.size() && run_.group.layers[at].name != e) ++at;
          fmt::print(" {}({})", e, at < run_.group.layers.size() ? int(at) : -1);
        }
        fmt::print("\n");
      }
      fmt::print("{}", messages_);
    }
    for (const std::string& m : missing_) tell("error: ", m);
  }

  bool compile() {
    language::MachineOptions options;
    options.width = uint32_t(job_.width);
    options.optimise = job_.optimisation > 0;
    options.rangeCheck = job_.option("range_checking", 1) != 0;
    run_.group.perPoint = [this](const language::Layer& layer, const language::Symbol& parameter) {
      const std::string name = layer.name + "." + parameter.name;
      const bool isFree = run_.unlocked.count(name) || (!parameter.lockGeometry && !run_.locked.count(name));
      language::PerPoint p;
      p.isVarying = isFree && world_.hasPrimvar(parameter.name, parameter.type);
      p.isConnected = isFree && job_.userDataIsConnected;
      p.isPartial = p.isVarying && world_.isPartial(parameter.name);
      p.hasDerivs = p.isVarying && parameter.type.base == Base::Float && parameter.type.arrayLength == 0;
      return p;
    };
    std::string error;
    code_ = compileGroup(run_.group, options, error);
    if (!code_) {
      tell("error: ", error);
      return false;
    }
    inputs_ = code_->inputsOf(run_.group);
    return true;
  }

  bool reparameter() {
    for (size_t i = 0; i < run_.reparams.size(); ++i) {
      language::Layer* layer = nullptr;
      for (language::Layer& l : run_.group.layers)
        if (l.name == run_.reparamLayers[i]) layer = &l;
      if (!layer) {
        tell("error: ", fmt::format("--reparam: no layer is named '{}'", run_.reparamLayers[i]));
        return false;
      }
      layer->settings.push_back(run_.reparams[i]);
    }
    return compile();
  }

  struct Slice {
    uint64_t first = 0;
    uint32_t count = 0;
    std::vector<Spoken> spoken;
    std::vector<std::vector<float>> values;  // by wanted output: components one after the other
  };
  struct Worker {
    std::unique_ptr<ShadeWorld::Slice> points;
    language::RunState state;
  };

  void iterate(bool isLast) {
    const uint64_t points = job_.grid.points();
    tbb::task_arena arena(job_.threads > 0 ? job_.threads : tbb::task_arena::automatic);
    const uint32_t workers = uint32_t(std::clamp(arena.max_concurrency(), 1, int(kSlices)));
    while (workers_.size() < workers) {
      workers_.push_back(std::make_unique<Worker>());
      workers_.back()->points = std::make_unique<ShadeWorld::Slice>(world_, dictionary_, kSlicePoints);
    }
    std::vector<Slice> slices;
    for (uint64_t begin = 0; begin < points; begin += uint64_t(kSlices) * kSlicePoints) {
      slices.clear();
      for (uint64_t at = begin; at < points && slices.size() < kSlices; at += kSlicePoints)
        slices.push_back({at, uint32_t(std::min<uint64_t>(kSlicePoints, points - at)), {}, {}});
      std::atomic<size_t> next = 0;
      const auto work = [&](Worker& worker) {
        for (size_t i; (i = next++) < slices.size();) shade(worker, slices[i]);
      };
      const uint32_t used = uint32_t(std::min<size_t>(workers, slices.size()));
      if (used == 1)
        work(*workers_[0]);
      else
        arena.execute([&] { tbb::parallel_for(0u, used, [&](uint32_t w) { work(*workers_[w]); }); });
      for (const Slice& slice : slices) tellAll(slice, isLast);
    }
  }

  void shade(Worker& worker, Slice& slice) {
    const uint32_t padded = (slice.count + 15) / 16 * 16;
    worker.points->fill(slice.first, slice.count);
    language::RendererServices services = worker.points->services();
    std::vector<language::OutputValues> outputs(code_->outputs().size());
    std::vector<std::vector<float*>> cells(outputs.size());
    slice.values.resize(wanted_.size());
    for (size_t k = 0; k < wanted_.size(); ++k) {
      slice.values[k].assign(size_t(wanted_[k].channels) * padded, 0.f);
      for (uint32_t c = 0; c < wanted_[k].channels; ++c)
        cells[wanted_[k].output].push_back(slice.values[k].data() + size_t(c) * padded);
    }
    for (size_t k = 0; k < outputs.size(); ++k) outputs[k] = {cells[k].data()};
    language::RunArguments arguments;
    arguments.points = slice.count;
    arguments.globals = &worker.points->globals();
    arguments.inputs = inputs_.data();
    arguments.varyingInputs = worker.points->inputs(*code_, run_.group);
    arguments.outputs = outputs.data();
    arguments.services = &services;
    arguments.tellsEveryPoint = true;
    arguments.listener = [](void* self, uint32_t point, MessageKind kind, const std::string& text,
                            const std::string& file) {
      static_cast<std::vector<Spoken>*>(self)->push_back({point, kind, text, file});
    };
    arguments.listening = &slice.spoken;
    code_->run(worker.state, arguments);
  }

  void tellAll(const Slice& slice, bool isLast) {
    const uint32_t padded = (slice.count + 15) / 16 * 16;
    size_t next = 0;
    for (uint32_t i = 0; i < slice.count; ++i) {
      for (; next < slice.spoken.size() && slice.spoken[next].point == i; ++next) speaker_.say(slice.spoken[next]);
      if (!isLast) continue;
      const uint64_t at = slice.first + i;
      if (job_.printsOutputs) fmt::print("Pixel ({}, {}):\n", at % job_.grid.width, at / job_.grid.width);
      for (size_t k = 0; k < wanted_.size(); ++k) {
        Wanted& w = wanted_[k];
        std::string line;
        for (uint32_t c = 0; c < w.channels; ++c) {
          const float f = slice.values[k][size_t(c) * padded + i];
          int32_t n;
          std::memcpy(&n, &f, 4);
          const bool isInt = w.base == Base::Int;
          if (job_.printsOutputs) line += isInt ? fmt::format(" {}", n) : fmt::format(" {:g}", f);
          if (!w.pixels.empty()) w.pixels[at * w.channels + c] = isInt ? float(n) : f;
        }
        if (job_.printsOutputs) fmt::print("  {} :{}\n", w.name, line);
      }
    }
  }

  int write() {
    int worst = kComplete;
    for (Wanted& w : wanted_) {
      if (w.pixels.empty()) continue;
      image::StoredType type = job_.storedType == "uint8"  ? image::StoredType::UInt8
                               : job_.storedType == "half" ? image::StoredType::Half
                                                           : image::StoredType::Float;
      std::vector<image::ChannelInfo> channels;
      static constexpr const char* kNames[] = {"R", "G", "B"};
      for (uint32_t c = 0; c < w.channels; ++c)
        channels.push_back({w.channels == 1   ? std::string("Y")
                            : w.channels == 3 ? std::string(kNames[c])
                                              : fmt::format("channel{}", c),
                            type});
      image::Image picture;
      picture.data = picture.display = {0, 0, int(job_.grid.width), int(job_.grid.height)};
      picture.channels = std::move(channels);
      picture.pixels = std::move(w.pixels);
      image::WriteOptions options;
      // pictures for screens are encoded for them, data are not
      const std::string ending = fs::path(w.file).extension().string();
      options.encodeSrgb = ending == ".png" || ending == ".jpg" || ending == ".jpeg" || ending == ".gif";
      const image::Status status = image::write(w.file, picture, options);
      if (status.ok()) continue;
      tell("error: ", status.what);
      worst = kCannotWrite;
    }
    return worst;
  }

  void statistics(std::chrono::steady_clock::duration compiling, std::chrono::steady_clock::duration running) {
    const double points = double(job_.grid.points()) * job_.iterations;
    const double seconds = std::chrono::duration<double>(running).count();
    fmt::print("\nlayers {}\ninstructions {}\nvalues {}\nwidth {}\npoints a block {}\n", run_.group.layers.size(),
               code_->instructionCount(), code_->slotCount(), code_->width(), code_->blockPoints());
    fmt::print("compile {:.3f} ms\nrun {:.3f} ms\nnanoseconds a point {:.1f}\n",
               std::chrono::duration<double, std::milli>(compiling).count(), seconds * 1e3, seconds * 1e9 / points);
  }

  const RunJob& job_;
  RunGroup& run_;
  ShadeWorld world_;
  Speaker speaker_;
  language::Dictionary dictionary_{[](const std::string& problem) {
    std::fflush(stdout);
    fmt::print(stderr, "ERROR: {}\n", problem);
  }};
  std::shared_ptr<const language::Executable> code_;
  std::vector<float> inputs_;
  std::vector<Wanted> wanted_;
  std::vector<std::string> missing_;
  std::string messages_;
  bool hasMissingOutput_ = false;
  std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace

int runShaderRun(const Arguments& arguments) {
  RunJob job;
  if (const std::optional<int> done = parseRun(arguments, job)) return *done;
  if (!job.colorSpace.empty()) {
    const language::ColorSystem* system = language::findColorSystem(job.colorSpace);
    Diagnostics diagnostics;
    if (!system)
      return badCommandLine(diagnostics, "--colorspace: '" + job.colorSpace + "' is no colour space",
                            "Rec709, sRGB, ACEScg, ACES2065-1, AdobeRGB, NTSC, PAL, SMPTE, HDTV, CIE, XYZ ...");
    language::setDefaultColorSystem(*system);
  }
  RunGroup group;
  if (!makeGroup(job, group)) return 1;
  return Runner(job, group).run();
}

}  // namespace kinora::app
