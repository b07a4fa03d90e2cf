// Control flow: jumps where all points agree, masks where they may not. A mask only ever narrows; what leaves a
// region early is taken out of the masks of every region up to the one that it leaves.
#include "language/vm/codegen.h"

namespace kinora::language {

CodeGenerator::Register CodeGenerator::maskOf(int32_t region) {
  while (masks_[size_t(region)] == kNoRegister) region = a_.regions[size_t(region)].parent;
  return masks_[size_t(region)];
}

// From here on, kernels work on the chunks that a region's points lie in.
void CodeGenerator::useChunks(int32_t region) {
  while (region > 0 && chunks_[size_t(region)] == kNoRegister) region = a_.regions[size_t(region)].parent;
  if (chunks_[size_t(region)] == kNoRegister)
    emitJump(Step::AllChunks);
  else
    emitJump(Step::Chunks, chunks_[size_t(region)], maskOf(region));
}

CodeGenerator::Operand CodeGenerator::asInt(Operand o) {
  if (o.base == Base::Int || o.base == Base::String) return o;
  Operand made = temporary(Base::Int, 1, o.varies);
  word(1);
  reference(made.reg);
  reference(o.reg, o.at);
  word(0);
  emit(Integer::NotZeroF, !o.varies);
  return made;
}

void CodeGenerator::block(const Block& code, int32_t region) {
  const int32_t outer = region_;
  region_ = region;
  for (const Instruction& in : code.code) {
    if (isFused(in)) continue;
    switch (in.opcode) {
      case Opcode::Nop:
      case Opcode::End:
      case Opcode::UseParam:
        break;
      case Opcode::If:
        branch(in, region);
        break;
      case Opcode::For:
      case Opcode::While:
      case Opcode::DoWhile:
        loop(in, region);
        break;
      case Opcode::Call:
        call(in, region);
        break;
      case Opcode::Break:
      case Opcode::Continue:
      case Opcode::Return:
      case Opcode::Exit: {
        int32_t target = region;
        const auto leaves = [&](Region::Kind kind) {
          switch (in.opcode) {
            case Opcode::Break:
              return kind == Region::Loop;
            case Opcode::Continue:
              return kind == Region::Body;
            case Opcode::Return:
              return kind == Region::Call || kind == Region::Layer;
            default:
              return kind == Region::Layer;
          }
        };
        while (target > 0 && !leaves(a_.regions[size_t(target)].kind)) target = a_.regions[size_t(target)].parent;
        leave(region, target);
        break;
      }
      default:
        operation(in);
        break;
    }
  }
  region_ = outer;
}

void CodeGenerator::branch(const Instruction& in, int32_t region) {
  const Instruction* test = fused_[size_t(in.arguments[0])];
  Operand condition;
  if (test)
    condition.varies = true;
  else
    condition = operand(in.arguments[0]);
  if (condition.components > 1) return fail(in, "a condition must be a single number");
  if (!test) condition = asInt(condition);
  const Block* no = in.blocks.size() > 1 && !in.blocks[1].code.empty() ? &in.blocks[1] : nullptr;
  const int32_t yesRegion = a_.regionOf.at(&in.blocks[0]);
  if (!condition.varies) {
    const size_t skip = emitJump(Step::JumpUnless, condition.reg);
    block(in.blocks[0], yesRegion);
    if (!no) return land(skip);
    const size_t end = emitJump(Step::Jump);
    land(skip);
    block(*no, a_.regionOf.at(no));
    land(end);
    return;
  }
  const Register yes = newRegister(1, false), other = newRegister(1, false), anyYes = newRegister(1, true),
                 anyNo = newRegister(1, true);
  reference(yes);
  reference(other);
  reference(anyYes);
  reference(anyNo);
  reference(maskOf(region));
  if (test) {
    conditionWords(*test);
    emit(Fused(int(Fused::Split) + int(conditionOf(*test))), false);
  } else {
    reference(condition.reg, condition.at);
    emit(Memory::MaskSplit, false);
  }
  masks_[size_t(yesRegion)] = yes;
  chunks_[size_t(yesRegion)] = anyYes;
  if (!in.blocks[0].code.empty()) {
    const size_t skip = emitJump(Step::JumpUnless, anyYes);
    useChunks(yesRegion);
    block(in.blocks[0], yesRegion);
    useChunks(region);
    land(skip);
  }
  if (no) {
    const int32_t noRegion = a_.regionOf.at(no);
    masks_[size_t(noRegion)] = other;
    chunks_[size_t(noRegion)] = anyNo;
    const size_t skip = emitJump(Step::JumpUnless, anyNo);
    useChunks(noRegion);
    block(*no, noRegion);
    useChunks(region);
    land(skip);
  }
}

void CodeGenerator::loop(const Instruction& in, int32_t region) {
  const int32_t own = a_.regionOf.at(&in), body = a_.regionOf.at(&in.blocks[2]);
  const bool diverges = a_.regions[size_t(own)].isDivergent;
  block(in.blocks[0], region);
  const Register any = newRegister(1, true), count = newRegister(1, true);
  word(1);
  reference(count);
  word(0);
  emit(Memory::Fill, true);
  // all points may have left the code around it: nobody would ever end the loop
  const bool mayBeEmpty = maskOf(region) != rootMask_ && (!diverges || in.opcode == Opcode::DoWhile);
  size_t skip = 0;
  if (mayBeEmpty) {
    reference(maskOf(region));
    reference(any);
    emit(Memory::MaskAny, false);
    skip = emitJump(Step::JumpUnless, any);
  }
  if (diverges) {
    masks_[size_t(own)] = newRegister(1, false);
    reference(masks_[size_t(own)]);
    reference(maskOf(region));
    emit(Memory::MaskCopy, false);
  }
  const int32_t first = int32_t(e_->code_.size());
  std::vector<size_t> exits;
  const auto test = [&] {
    block(in.blocks[1], own);
    const SymbolId asked = in.arguments[0];
    const int32_t outer = region_;
    region_ = own;
    if (a_.isVarying[size_t(asked)]) {  // such a loop diverges
      narrowMask(asked, own, any);
    } else {
      exits.push_back(emitJump(Step::JumpUnless, asInt(operand(asked)).reg));
      if (diverges) {
        reference(masks_[size_t(own)]);
        reference(any);
        emit(Memory::MaskAny, false);
      }
    }
    region_ = outer;
    if (!diverges) return;
    exits.push_back(emitJump(Step::JumpUnless, any));
    chunks_[size_t(own)] = any;
    useChunks(own);
  };
  if (in.opcode != Opcode::DoWhile) test();
  scopes_.push_back({own, {}});
  scopes_.push_back({body, {}});
  if (a_.regions[size_t(body)].isDivergent) {
    masks_[size_t(body)] = newRegister(1, false);
    reference(masks_[size_t(body)]);
    reference(maskOf(own));
    emit(Memory::MaskCopy, false);
  }
  block(in.blocks[2], body);
  for (const size_t jump : scopes_.back().jumps) land(jump);
  scopes_.pop_back();
  block(in.blocks[3], own);
  if (in.opcode == Opcode::DoWhile) test();
  reference(count);
  word(site(in));
  const uint32_t ofShader = size_t(in.layer) < flat_.mostTurns.size() ? flat_.mostTurns[size_t(in.layer)] : 0;
  word(ofShader ? ofShader : e_->iterationLimit_);
  const size_t back = emit(Scalar::LoopLimit, true);
  e_->code_[back].step = Step::Back;
  e_->code_[back].target = uint32_t(first);
  for (const size_t jump : exits) land(jump);
  for (const size_t jump : scopes_.back().jumps) land(jump);
  scopes_.pop_back();
  const int32_t last = int32_t(e_->code_.size()) - 1;
  if (diverges) {
    touch(masks_[size_t(own)], last);
    useChunks(region);
  }
  if (mayBeEmpty) land(skip);
  loops_.push_back({first, last, own});
}

void CodeGenerator::call(const Instruction& in, int32_t region) {
  const int32_t own = a_.regionOf.at(&in.blocks[0]);
  if (a_.regions[size_t(own)].isDivergent) {
    masks_[size_t(own)] = newRegister(1, false);
    reference(masks_[size_t(own)]);
    reference(maskOf(region));
    emit(Memory::MaskCopy, false);
  }
  scopes_.push_back({own, {}});
  block(in.blocks[0], own);
  for (const size_t jump : scopes_.back().jumps) land(jump);
  scopes_.pop_back();
}

void CodeGenerator::leave(int32_t region, int32_t target) {
  if (!a_.regions[size_t(target)].isDivergent) {
    for (Scope& scope : scopes_)
      if (scope.region == target) {
        scope.jumps.push_back(emitJump(Step::Jump));
        return;
      }
    emitJump(Step::End);  // the top of a program without layers
    return;
  }
  const Register own = maskOf(region);
  Register last = own;
  for (int32_t r = region;; r = a_.regions[size_t(r)].parent) {
    const Register mask = maskOf(r);
    if (mask != last) {
      reference(mask);
      reference(own);
      emit(Memory::MaskClear, false);
      last = mask;
    }
    if (r == target) break;
  }
  word(1);
  reference(own);
  word(0);
  emit(Memory::Fill, false);
}

}  // namespace kinora::language
