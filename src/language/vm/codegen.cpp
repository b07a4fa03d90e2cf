#include "language/vm/codegen.h"

#include <algorithm>
#include <atomic>
#include <cstring>

#include "language/vm/strings.h"
#include "simd/dispatch.h"

namespace kinora::language {

namespace {

constexpr uint32_t kMostCells = 1u << 22;
constexpr uint32_t kL1Bytes = 32 * 1024;

uint32_t bitsOf(float f) {
  uint32_t bits;
  std::memcpy(&bits, &f, 4);
  return bits;
}

const KernelFunction* kernelsOf(Family family, uint32_t width) {
  switch (family) {
    case Family::Arithmetic:
      return arithmeticKernels(width);
    case Family::Math:
      return mathKernels(width);
    case Family::Mixed:
      return mixedKernels(width);
    case Family::Integer:
      return integerKernels(width);
    case Family::Memory:
      return memoryKernels(width);
    case Family::Vector:
      return vectorKernels(width);
    case Family::Color:
      return colorKernels(width);
    case Family::Spline:
      return splineKernels(width);
    case Family::Noise:
      return noiseKernels(width);
    case Family::Fused:
      return fusedKernels(width);
    default:
      return scalarKernels();
  }
}

}  // namespace

CodeGenerator::Register CodeGenerator::newRegister(uint32_t cells, bool isUniform) {
  RegisterFacts facts;
  facts.cells = cells;
  facts.isUniform = isUniform;
  registers_.push_back(facts);
  return Register(registers_.size() - 1);
}

CodeGenerator::Operand CodeGenerator::temporary(Base base, uint32_t components, bool varies, bool derivs) {
  Operand o;
  o.base = base;
  o.components = components;
  o.varies = varies;
  o.derivs = derivs;
  o.reg = newRegister(components * (derivs ? 3 : 1), !varies);
  return o;
}

CodeGenerator::Operand CodeGenerator::operand(SymbolId s) {
  const Symbol& symbol = shader_.symbols[size_t(s)];
  Operand o;
  o.base = symbol.type.base;
  o.components = uint32_t(std::max(1, componentsOf(o.base)));
  o.elements = uint32_t(std::max(1, symbol.type.arrayLength));
  o.varies = a_.isVarying[size_t(s)];
  o.derivs = a_.hasDerivs[size_t(s)];
  o.reg = ofSymbol_[size_t(s)];
  if (o.reg == kNoRegister) {
    o.reg = newRegister(o.cells() * (o.derivs ? 3 : 1), !o.varies);
    registers_[size_t(o.reg)].symbol = s;
    ofSymbol_[size_t(s)] = o.reg;
    if (symbol.kind == SymbolKind::Constant) {
      std::vector<uint32_t> image;
      for (const int32_t i : symbol.values.ints) image.push_back(uint32_t(i));
      for (const float f : symbol.values.floats) image.push_back(bitsOf(f));
      for (const std::string& t : symbol.values.strings) image.push_back(uint32_t(internString(t)));
      image.resize(o.cells());
      images_.emplace_back(o.reg, std::move(image));
    }
  }
  return o;
}

CodeGenerator::Operand CodeGenerator::part(Operand o, uint32_t component) const {
  o.at += component;  // derivatives stay where they are: a third and two thirds of the register further on
  o.components = o.elements = 1;
  return o;
}

CodeGenerator::Operand CodeGenerator::constant(float f) {
  Operand o = temporary(Base::Float, 1, false);
  images_.emplace_back(o.reg, std::vector<uint32_t>{bitsOf(f)});
  return o;
}
CodeGenerator::Operand CodeGenerator::constantInt(int32_t i) {
  Operand o = temporary(Base::Int, 1, false);
  images_.emplace_back(o.reg, std::vector<uint32_t>{uint32_t(i)});
  return o;
}

CodeGenerator::Register CodeGenerator::zeros() {
  if (zeros_ == kNoRegister) {
    zeros_ = newRegister(1, false);
    registers_[size_t(zeros_)].isFixed = true;
  }
  return zeros_;
}

void CodeGenerator::reference(Register reg, uint32_t at) {
  relocations_.push_back({uint32_t(e_->words_.size()), reg});
  word(at);
}

void CodeGenerator::touch(Register reg, int32_t instruction) {
  RegisterFacts& facts = registers_[size_t(reg)];
  facts.first = std::min(facts.first, instruction);
  facts.last = std::max(facts.last, instruction);
}

// Call it when the instruction's words have been written.
size_t CodeGenerator::emit(KernelName kernel, bool once) {
  const KernelFunction* table =
      e_->width_ == 16 && !once && options_.kernels16 ? options_.kernels16(kernel.family) : nullptr;
  if (!table) table = kernelsOf(kernel.family, once ? 1 : e_->width_);
  MachineInstruction in;
  in.kernel = table[kernel.number];
  in.words = uint32_t(wordsDone_);
  in.step = once ? Step::RunOnce : Step::Run;
  const int32_t number = int32_t(e_->code_.size());
  while (!relocations_.empty() && firstRelocation_.size() < relocations_.size()) {
    touch(relocations_[firstRelocation_.size()].reg, number);
    firstRelocation_.push_back(size_t(number));
  }
  wordsDone_ = e_->words_.size();
  e_->code_.push_back(in);
  e_->names_.push_back(nameOfKernel(kernel));
  return size_t(number);
}

size_t CodeGenerator::emitJump(Step step, Register condition, Register mask) {
  MachineInstruction in;
  in.step = step;
  in.words = uint32_t(e_->words_.size());
  for (const Register r : {condition, mask})
    if (r != kNoRegister) {
      reference(r);
      touch(r, int32_t(e_->code_.size()));
      firstRelocation_.push_back(e_->code_.size());
    }
  wordsDone_ = e_->words_.size();
  e_->code_.push_back(in);
  e_->names_.push_back(step == Step::Jump         ? "-> jump"
                       : step == Step::End        ? "end"
                       : step == Step::JumpUnless ? "-> jump unless"
                                                  : "chunks");
  return e_->code_.size() - 1;
}

CodeGenerator::Target CodeGenerator::begin(SymbolId result, bool isUniform, std::initializer_list<Operand> operands,
                                           bool elementwise) {
  Target t;
  t.final = operand(result);
  t.out = t.final;
  if (!t.final.varies) {
    t.once = true;
    if (!elementwise)
      for (const Operand& o : operands) t.copies |= o.reg == t.final.reg;
    if (t.copies) t.out = temporary(t.final.base, t.final.cells(), false);
    return t;
  }
  t.blends = a_.blends(region_, result);
  if (isUniform) {
    t.once = t.spreads = true;
    t.out = temporary(t.final.base, t.final.cells(), false);
  } else if (t.blends) {
    t.out = temporary(t.final.base, t.final.cells(), true, t.final.derivs);
  } else if (!elementwise) {
    for (const Operand& o : operands) t.copies |= o.reg == t.final.reg;
    if (t.copies) t.out = temporary(t.final.base, t.final.cells(), true, t.final.derivs);
  }
  t.out.components = t.final.components;
  t.out.elements = t.final.elements;
  return t;
}

void CodeGenerator::copyCells(Register to, uint32_t toAt, Register from, uint32_t fromAt, uint32_t n, bool fromVaries,
                              uint32_t step) {
  const bool once = registers_[size_t(to)].isUniform;
  word(n);
  reference(to, toAt);
  reference(from, fromAt);
  word(step);
  emit(fromVaries || once ? Memory::Copy : Memory::Broadcast, once);
}

void CodeGenerator::finish(const Target& t) {
  const uint32_t n = t.final.cells();
  if (t.copies) {
    copyCells(t.final.reg, t.final.at, t.out.reg, 0, n * (t.final.derivs ? 3 : 1), t.final.varies, 1);
    return;
  }
  if (t.spreads && !t.blends) {
    copyCells(t.final.reg, t.final.at, t.out.reg, 0, n, false, 1);
    clearDerivs(t.final, false);
    return;
  }
  if (!t.blends) return;
  const Register mask = maskOf(region_);
  word(t.spreads ? n : n * (t.final.derivs ? 3 : 1));
  reference(t.final.reg, t.final.at);
  reference(t.out.reg);
  word(1);
  reference(mask);
  emit(t.spreads ? Memory::BlendUniform : Memory::Blend, false);
  if (t.spreads && t.final.derivs) {
    const Operand zero = constant(0.f);
    word(2 * n);
    reference(t.final.reg, t.final.at + n);
    reference(zero.reg);
    word(0);
    reference(mask);
    emit(Memory::BlendUniform, false);
  }
}

void CodeGenerator::clearDerivs(const Operand& o, bool once) {
  if (!o.derivs || once) return;
  word(2 * o.cells());
  reference(o.reg, o.cells());
  word(0);
  emit(Memory::Fill, false);
}

void CodeGenerator::plainWords(const Operand& o, uint32_t wanted) {
  reference(o.reg, o.at);
  word(wanted > 1 && o.components > 1 ? 1 : 0);
}
void CodeGenerator::mixedWords(const Operand& o, uint32_t wanted) {
  plainWords(o, wanted);
  word(o.varies);
}
void CodeGenerator::dualWords(const Operand& o, uint32_t wanted) {
  plainWords(o, wanted);
  if (o.derivs) {
    const uint32_t all = registers_[size_t(o.reg)].cells / 3;
    reference(o.reg, o.at + all);
    reference(o.reg, o.at + 2 * all);
    word(wanted > 1 && o.components > 1 ? 1 : 0);
  } else {
    reference(zeros());
    reference(zeros());
    word(0);
  }
}
void CodeGenerator::dualMixedWords(const Operand& o, uint32_t wanted) {
  dualWords(o, wanted);
  word(o.varies);
}
void CodeGenerator::resultWords(const Operand& o, bool dual) {
  reference(o.reg, o.at);
  if (!dual) return;
  const uint32_t all = registers_[size_t(o.reg)].cells / 3;
  reference(o.reg, o.at + all);
  reference(o.reg, o.at + 2 * all);
}

uint32_t CodeGenerator::site(const Instruction& in, std::string name) {
  Site s;
  s.position = in.pos.str();
  s.layer = in.layer;
  s.name = std::move(name);
  e_->sites_.push_back(std::move(s));
  return uint32_t(e_->sites_.size() - 1);
}

void CodeGenerator::fail(const Instruction& in, const std::string& what) {
  if (error_.size() > 4000) return;
  const std::string at = in.pos.str();
  error_ += (at.empty() ? "" : at + ": ") + "error: " + what + " (layer " + flat_.layers[size_t(in.layer)] +
            ", shader " + flat_.shaders[size_t(in.layer)] + ")\n";
}

// Symbols that come from outside, or that must hold zeros.
void CodeGenerator::bindSymbols() {
  std::vector<uint8_t> isWritten(shader_.symbols.size());
  uint32_t varyingInput = 0;
  const auto external = [&](Register reg, Executable::External::Kind kind, uint32_t index, const Operand& o) {
    registers_[size_t(reg)].isFixed = true;
    for (uint32_t k = 0; k < registers_[size_t(reg)].cells; ++k) {
      Executable::External x;
      x.kind = kind;
      x.index = index;
      x.part = uint8_t(k / o.cells());
      x.component = k % o.cells();
      x.cell = uint32_t(reg);  // the register until cells are laid out
      x.fallback = k;
      e_->externals_.push_back(x);
    }
  };
  for (size_t s = 0; s < shader_.symbols.size(); ++s) {
    if (a_.home[s] < 0 && shader_.symbols[s].kind != SymbolKind::Param) continue;
    if (shader_.symbols[s].kind != SymbolKind::Global) continue;
    const int32_t name = GlobalValues::named(shader_.symbols[s].name);
    if (name < 0) continue;
    const Operand o = operand(SymbolId(s));
    external(o.reg, Executable::External::Global, uint32_t(name), o);
  }
  for (const Input& input : flat_.inputs) {
    const Operand o = operand(input.symbol);
    if (!input.isVarying) continue;
    if (o.elements == 1) {
      external(o.reg, Executable::External::Input, varyingInput++, o);
    } else {  // elements of an array lie side by side: copied there when a block begins
      const Register outside = newRegister(registers_[size_t(o.reg)].cells, false);
      external(outside, Executable::External::Input, varyingInput++, o);
      copiedIn_.emplace_back(o.reg, outside);
    }
  }
  uint32_t number = 0;
  for (const Output& output : flat_.outputs) {
    const SymbolKind kind = shader_.symbols[size_t(output.symbol)].kind;
    const uint32_t index = number++;
    if (kind != SymbolKind::Local && kind != SymbolKind::Temp) continue;  // an input or a constant handed through
    if (!a_.isVarying[size_t(output.symbol)] || a_.hasDerivs[size_t(output.symbol)] ||
        ofSymbol_[size_t(output.symbol)] != kNoRegister)
      continue;
    const Operand o = operand(output.symbol);
    if (o.elements > 1) continue;
    external(o.reg, Executable::External::Output, index, o);
  }
}

bool CodeGenerator::run(Executable& executable, std::string& error) {
  e_ = &executable;
  e_->width_ = options_.width ? options_.width : bestWidth();
  if (!arithmeticKernels(e_->width_) || (e_->width_ == 16 && !cpuHasAvx512() && !options_.kernels16)) {
    error = "programs of width " + std::to_string(e_->width_) + " cannot run here";
    return false;
  }
  e_->group_ = flat_.group;
  e_->layers_ = flat_.layers;
  e_->shaders_ = flat_.shaders;
  e_->inputs_ = flat_.inputs;
  e_->outputs_ = flat_.outputs;
  e_->warnings_ = flat_.warnings;
  e_->iterationLimit_ = std::max(1u, options_.iterationLimit);
  e_->mostTurns_ = e_->iterationLimit_;
  for (const uint32_t n : flat_.mostTurns) e_->mostTurns_ = std::max(e_->mostTurns_, uint64_t(n));
  e_->mostTurns_ *= 16;
  e_->rangeCheck_ = options_.rangeCheck;
  a_ = analyse(flat_);
  ofSymbol_.assign(shader_.symbols.size(), kNoRegister);
  masks_.assign(a_.regions.size(), kNoRegister);
  chunks_ = masks_;
  findFused();
  bindSymbols();
  // the mask of all points stands first; without a reader it is jumped over
  rootMask_ = newRegister(1, false);
  masks_[0] = rootMask_;
  reference(rootMask_);
  emit(Memory::MaskAll, false);
  for (const auto& [inside, outside] : copiedIn_)
    copyCells(inside, 0, outside, 0, registers_[size_t(inside)].cells, true, 1);
  for (size_t s = 0; s < shader_.symbols.size(); ++s) {
    if (!a_.needsZero[s] || a_.home[s] < 0 || componentsOf(shader_.symbols[s].type.base) == 0) continue;
    const Operand o = operand(SymbolId(s));
    word(registers_[size_t(o.reg)].cells);
    reference(o.reg);
    word(0);
    emit(Memory::Fill, !o.varies);
  }
  block(shader_.main, 0);
  emitJump(Step::End);
  const int32_t end = int32_t(e_->code_.size()) - 1;
  for (const Output& output : flat_.outputs) touch(operand(output.symbol).reg, end);
  if (registers_[size_t(rootMask_)].last == 0) {
    e_->code_[0].step = Step::Jump;
    e_->code_[0].target = 1;
  }
  if (error_.empty() && layOut()) return true;
  if (!error_.empty() && error_.back() == '\n') error_.pop_back();
  error = error_;
  return false;
}

bool CodeGenerator::layOut() {
  for (const Loop& loop : loops_) {
    for (RegisterFacts& r : registers_) {
      if (r.last < 0 || r.isUniform) continue;
      if (r.first < loop.first && r.last >= loop.first) r.last = std::max(r.last, loop.last);
      if (r.symbol == kNone || r.first > loop.last || r.last < loop.first) continue;
      bool outside = true;  // home is not inside the loop
      for (int32_t h = a_.home[size_t(r.symbol)]; h >= 0; h = a_.regions[size_t(h)].parent)
        if (h == loop.region) outside = false;
      if (outside) r.first = std::min(r.first, loop.first), r.last = std::max(r.last, loop.last);
    }
  }
  // uniform cells first, then those that point outside, then slots
  uint64_t cells = 0;
  for (RegisterFacts& r : registers_)
    if (r.isUniform) r.cell = uint32_t(cells), cells += r.cells;
  e_->uniforms_ = uint32_t(cells);
  for (RegisterFacts& r : registers_)
    if (r.isFixed) r.cell = uint32_t(cells), cells += r.cells;
  const uint32_t firstSlot = uint32_t(cells);
  std::vector<size_t> order;
  for (size_t i = 0; i < registers_.size(); ++i)
    if (!registers_[i].isUniform && !registers_[i].isFixed && registers_[i].last >= 0) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return registers_[a].first < registers_[b].first; });
  std::vector<int32_t> busyUntil;  // by slot: the last instruction of the value in it
  for (const size_t i : order) {
    RegisterFacts& r = registers_[i];
    size_t at = 0, free = 0;
    for (size_t s = 0; s < busyUntil.size() && free < r.cells; ++s) {
      if (busyUntil[s] < r.first)
        ++free;
      else
        free = 0, at = s + 1;
    }
    if (at + r.cells > busyUntil.size()) {
      if (at + r.cells > kMostCells) {
        error_ += "the shader group's values need more memory than a program may take\n";
        return false;
      }
      busyUntil.resize(at + r.cells, -1);
    }
    for (uint32_t k = 0; k < r.cells; ++k) busyUntil[at + k] = r.last;
    r.cell = firstSlot + uint32_t(at);
  }
  e_->slots_ = uint32_t(busyUntil.size());
  // (externals hold their register until here)
  // a place to write for outputs that nobody wants
  uint32_t fallback = e_->slots_;
  for (Executable::External& x : e_->externals_) {
    x.cell = registers_[size_t(x.cell)].cell + x.fallback;
    if (x.kind == Executable::External::Output) x.fallback = fallback++;
  }
  e_->slots_ = fallback;
  e_->cells_ = firstSlot + e_->slots_;
  if (cells + e_->slots_ > kMostCells) {
    error_ += "the shader group's values need more memory than a program may take\n";
    return false;
  }
  for (const Relocation& r : relocations_) e_->words_[r.word] += registers_[size_t(r.reg)].cell;
  e_->uniformImage_.assign(e_->uniforms_, 0);
  for (const auto& [reg, image] : images_)
    std::copy(image.begin(), image.end(), e_->uniformImage_.begin() + registers_[size_t(reg)].cell);
  for (const Input& input : flat_.inputs)
    if (!input.isVarying) e_->inputCells_.push_back(registers_[size_t(ofSymbol_[size_t(input.symbol)])].cell);
  for (const Output& output : flat_.outputs) {
    const Operand o = operand(output.symbol);
    e_->boundOutputs_.push_back({registers_[size_t(o.reg)].cell, o.cells(), o.varies, false, o.base});
  }
  for (const Executable::External& x : e_->externals_)
    if (x.kind == Executable::External::Output) e_->boundOutputs_[x.index].isDirect = true;
  // all that a block's instructions touch stays in the first cache; a mask of slots that live apart would be finer
  const uint32_t working = std::max(1u, e_->slots_);
  e_->blockPoints_ = options_.blockPoints ? (std::min(options_.blockPoints, 512u) + 15) / 16 * 16
                                          : std::clamp(kL1Bytes / 4 / working / 16 * 16, 64u, 512u);
  if (zeros_ != kNoRegister) {
    Executable::External x;
    x.kind = Executable::External::Global;
    x.index = GlobalValues::Count;  // zeros
    x.cell = registers_[size_t(zeros_)].cell;
    e_->externals_.push_back(x);
  }
  return true;
}

std::shared_ptr<const Executable> generate(const FlatProgram& flat, const MachineOptions& options,
                                           std::string& error) {
  static std::atomic<uint64_t> made{0};
  auto executable = std::make_shared<Executable>();
  executable->number_ = ++made;
  error.clear();
  if (!CodeGenerator(flat, options).run(*executable, error)) return nullptr;
  return executable;
}

}  // namespace kinora::language
