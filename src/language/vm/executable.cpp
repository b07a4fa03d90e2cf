#include "language/vm/executable.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <mutex>
#include <unordered_map>

#include "language/optimise/optimise.h"
#include "language/vm/strings.h"

namespace kinora::language {

namespace {

constexpr uint32_t kZeroPoints = 4096;

// Zeros for values that a caller does not give: read by whole blocks, never written.
const float* zeroPoints() {
  alignas(64) static const float kZeros[kZeroPoints] = {};
  return kZeros;
}

// Points of a mask within the chunks that take part.
uint32_t liveIn(const Frame& frame, const float* mask) {
  uint32_t n = 0;
  for (uint32_t i = 0; i < frame.points; ++i) {
    int32_t isLive;
    std::memcpy(&isLive, mask + i, 4);
    n += (frame.chunks >> (i / 16) & 1) && isLive;
  }
  return n;
}

}  // namespace

void RunCounts::add(const RunCounts& o) {
  runs += o.runs;
  points += o.points;
  counted += o.counted;
  instructions += o.instructions;
  uniform += o.uniform;
  lanesRun += o.lanesRun;
  lanesUsed += o.lanesUsed;
}

int32_t GlobalValues::named(std::string_view name) {
  static constexpr std::string_view kNames[] = {"P",  "I",       "N", "Ng", "dPdu", "dPdv",
                                                "Ps", "dPdtime", "u", "v",  "time", "dtime"};
  for (int32_t i = 0; i < int32_t(Count); ++i)
    if (kNames[i] == name) return i;
  return -1;
}

void RunState::attach(const Executable& e) {
  program = &e;
  if (attached_ == e.number_) return;
  attached_ = e.number_;
  const size_t uniforms = (size_t(e.uniforms_) + 15) / 16 * 16;
  const size_t floats = uniforms + (size_t(e.slots_) + kScratch) * e.stride() + 16;
  if (memory_.size() < floats + 16) memory_.assign(floats + 16, 0.f);
  if (cells_.size() < e.cells_) cells_.resize(e.cells_);
  float* base = memory_.data();
  base += (64 - (reinterpret_cast<uintptr_t>(base) & 63)) % 64 / 4;
  for (uint32_t i = 0; i < e.uniforms_; ++i) cells_[i] = base + i;
  varying_ = base + uniforms;
  for (uint32_t i = 0; i < e.slots_; ++i) cells_[e.cells_ - e.slots_ + i] = varying_ + size_t(i) * e.stride();
  scratch_ = varying_ + size_t(e.slots_) * e.stride();
  stride_ = e.stride();
  toldOnce.assign(e.sites_.size(), 0);
}

template <bool kCounts>
void Executable::runBlock(Frame frame, const Frame& once, [[maybe_unused]] RunCounts* counts) const {
  const uint32_t all = frame.chunks;
  uint64_t turnsLeft = mostTurns_;
  [[maybe_unused]] uint32_t used = frame.points;
  const uint32_t* const words = words_.data();
  for (const MachineInstruction* in = code_.data();;) {
    if (in->step == Step::Run) {
      in->kernel(frame, words + in->words);
      if constexpr (kCounts) {
        ++counts->instructions;
        counts->lanesRun += 16 * uint32_t(std::popcount(frame.chunks));
        counts->lanesUsed += used;
      }
      ++in;
    } else if (in->step == Step::RunOnce) {
      in->kernel(once, words + in->words);
      if constexpr (kCounts) ++counts->uniform;
      ++in;
    } else if (in->step == Step::JumpUnless) {
      int32_t value;
      std::memcpy(&value, frame.cells[words[in->words]], 4);
      in = value ? in + 1 : code_.data() + in->target;
    } else if (in->step == Step::Back) {
      const uint32_t* w = words + in->words;
      uint32_t turns;
      std::memcpy(&turns, frame.cells[w[0]], 4);
      ++turns;
      std::memcpy(frame.cells[w[0]], &turns, 4);
      if (turns < w[2] && --turnsLeft) {
        in = code_.data() + in->target;
      } else {
        const bool wasSpent = frame.run->isSpent;
        frame.run->isSpent |= turnsLeft == 0;
        if (!wasSpent) in->kernel(once, w);
        if (turnsLeft == 0) return;
        ++in;
      }
    } else if (in->step == Step::Chunks) {
      std::memcpy(&frame.chunks, frame.cells[words[in->words]], 4);
      if constexpr (kCounts) used = liveIn(frame, frame.cells[words[in->words + 1]]);
      ++in;
    } else if (in->step == Step::AllChunks) {
      frame.chunks = all;
      if constexpr (kCounts) used = frame.points;
      ++in;
    } else if (in->step == Step::Jump) {
      in = code_.data() + in->target;
    } else {
      break;
    }
  }
}

void Executable::run(RunState& state, const RunArguments& arguments) const {
  static const GlobalValues kNoGlobals;
  const GlobalValues& globals = arguments.globals ? *arguments.globals : kNoGlobals;
  static const RendererServices kNoServices;
  state.services = arguments.services ? arguments.services : &kNoServices;
  state.attach(*this);
  state.isSpent = false;
  state.tellsEveryPoint = arguments.tellsEveryPoint;
  std::fill(state.toldOnce.begin(), state.toldOnce.end(), uint8_t(0));
  float* const uniforms = uniforms_ ? state.cells_[0] : nullptr;
  if (uniforms_) std::memcpy(uniforms, uniformImage_.data(), size_t(uniforms_) * 4);
  if (arguments.inputs) {
    const float* from = arguments.inputs;
    size_t number = 0;
    for (const Input& input : inputs_) {
      if (input.isVarying) continue;
      const size_t n = size_t(componentsOf(input.type.base)) * size_t(std::max(1, input.type.arrayLength));
      std::memcpy(uniforms + inputCells_[number++], from, n * 4);
      from += n;
    }
  }
  RunCounts* counts = arguments.counts;
  if (counts) {
    counts->points += arguments.points;
    if (counts->runs++ % RunCounts::kEvery)
      counts = nullptr;
    else
      ++counts->counted;
  }
  float** const cells = state.cells_.data();
  for (uint32_t first = 0; first < arguments.points; first += blockPoints_) {
    for (const External& x : externals_) {
      const float* p = nullptr;
      if (x.kind == External::Global) {
        if (x.index < GlobalValues::Count) {
          const auto& values = globals.of[x.index];
          p = x.part == 0 ? values.v[x.component] : x.part == 1 ? values.dx[x.component] : values.dy[x.component];
        }
      } else if (x.kind == External::Input) {
        const VaryingInput* input = arguments.varyingInputs ? arguments.varyingInputs + x.index : nullptr;
        const float* const* arrays = !input ? nullptr : x.part == 0 ? input->v : x.part == 1 ? input->dx : input->dy;
        if (arrays) p = arrays[x.component];
      } else {
        float* const* arrays = arguments.outputs ? arguments.outputs[x.index].v : nullptr;
        if (arrays && arrays[x.component])
          p = arrays[x.component];
        else {
          cells[x.cell] = state.varying_ + size_t(x.fallback) * stride();
          continue;
        }
      }
      cells[x.cell] = const_cast<float*>(p ? p + first : zeroPoints());
    }
    state.closures.clear();
    const uint32_t points = std::min(blockPoints_, arguments.points - first);
    const uint32_t all = ~0u >> (32 - (points + 15) / 16);
    const Frame frame{cells, points, first, all, &state};
    const Frame once{cells, 1, first, 1, &state};
    if (counts)
      runBlock<true>(frame, once, counts);
    else
      runBlock<false>(frame, once, nullptr);
    for (size_t k = 0; k < boundOutputs_.size(); ++k) {
      const BoundOutput& bound = boundOutputs_[k];
      float* const* out = arguments.outputs ? arguments.outputs[k].v : nullptr;
      if (!out || bound.isDirect) continue;
      for (uint32_t c = 0; c < bound.components; ++c) {
        if (!out[c]) continue;
        const float* from = cells[bound.cell + c];
        if (bound.varies)
          std::memcpy(out[c] + first, from, size_t(frame.points) * 4);
        else
          std::fill(out[c] + first, out[c] + first + frame.points, from[0]);
      }
    }
  }
  if (state.spoken.empty()) return;
  std::stable_sort(state.spoken.begin(), state.spoken.end(),
                   [](const RunState::Spoken& a, const RunState::Spoken& b) { return a.point < b.point; });
  if (arguments.listener)
    for (const RunState::Spoken& s : state.spoken)
      arguments.listener(arguments.listening, s.point, s.kind, s.text, s.file);
  else if (state.services->message)
    for (const RunState::Spoken& s : state.spoken)
      state.services->message(state.services->self, s.kind, s.text.data(), uint32_t(s.text.size()), s.file.c_str());
  state.spoken.clear();
}

std::vector<float> Executable::inputsOf(const ShaderGroup& group) const {
  std::vector<float> out;
  for (const Input& input : inputs_) {
    if (input.isVarying) continue;
    Values values = input.values;
    if (size_t(input.layer) < group.layers.size())
      settingValues(group.layers[size_t(input.layer)], input.parameter, input.type, values);
    for (const float f : values.floats) out.push_back(f);
    for (const int32_t i : values.ints) {
      float bits;
      std::memcpy(&bits, &i, 4);
      out.push_back(bits);
    }
    for (const std::string& s : values.strings) {
      const int32_t handle = internString(s);
      float bits;
      std::memcpy(&bits, &handle, 4);
      out.push_back(bits);
    }
  }
  return out;
}

uint64_t Executable::bytes() const {
  const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  return sizeof *this + of(inputs_) + of(outputs_) + of(boundOutputs_) + of(code_) + of(words_) + of(names_) +
         of(sites_) + of(externals_) + of(uniformImage_) + of(inputCells_);
}

std::string Executable::listing() const {
  std::string text;
  for (size_t i = 0; i < code_.size(); ++i) {
    const MachineInstruction& in = code_[i];
    text += std::to_string(i) + "\t" + names_[i] + (in.step == Step::RunOnce ? "  once" : "");
    const uint32_t end = i + 1 < code_.size() ? code_[i + 1].words : uint32_t(words_.size());
    for (uint32_t w = in.words; w < end && w < in.words + 16; ++w) text += " " + std::to_string(words_[w]);
    if (in.step == Step::Jump || in.step == Step::JumpUnless) text += " -> " + std::to_string(in.target);
    text += "\n";
  }
  return text;
}

std::shared_ptr<const Executable> compileGroup(const ShaderGroup& group, const MachineOptions& options,
                                               std::string& error) {
  FlatProgram flat;
  if (!flatten(group, flat, error)) return nullptr;
  makeClosureValues(flat);
  if (options.optimise) optimise(flat);
  chooseNames(flat);
  return generate(flat, options, error);
}

struct ExecutableCache::Entries {
  mutable std::mutex mutex;
  struct Entry {
    std::shared_ptr<const Executable> program;
    std::vector<std::shared_ptr<const Shader>> shaders;  // the key holds their addresses
  };
  std::unordered_map<std::string, Entry> byKey;
};

ExecutableCache::ExecutableCache() : entries_(std::make_shared<Entries>()) {}

std::shared_ptr<const Executable> ExecutableCache::get(const ShaderGroup& group, const MachineOptions& options,
                                                       std::string& error) {
  const std::string key = structureKey(group) + "|" + std::to_string(options.width) + "," +
                          std::to_string(options.iterationLimit) + "," + std::to_string(options.blockPoints) + "," +
                          std::to_string(options.optimise) + std::to_string(options.rangeCheck);
  const std::lock_guard lock(entries_->mutex);
  const auto found = entries_->byKey.find(key);
  if (found != entries_->byKey.end()) return found->second.program;
  std::shared_ptr<const Executable> made = compileGroup(group, options, error);
  if (!made) return nullptr;
  Entries::Entry entry{made, {}};
  for (const Layer& layer : group.layers) entry.shaders.push_back(layer.shader);
  entries_->byKey.emplace(key, std::move(entry));
  return made;
}

void ExecutableCache::forget(const Shader& shader) {
  const std::lock_guard lock(entries_->mutex);
  std::erase_if(entries_->byKey, [&](const auto& entry) {
    return std::any_of(entry.second.shaders.begin(), entry.second.shaders.end(),
                       [&](const auto& s) { return s.get() == &shader; });
  });
}

size_t ExecutableCache::size() const {
  const std::lock_guard lock(entries_->mutex);
  return entries_->byKey.size();
}

}  // namespace kinora::language
