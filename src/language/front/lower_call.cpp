// Calls: functions of the source are inlined, those of the library become instructions.
#include <algorithm>

#include "language/front/lower.h"

namespace kinora::language::front {

// Something that is written by whoever is called: the symbol itself where it is one of the right type, else a copy
// that is stored back.
Lowerer::Argument Lowerer::output(Expr* e, const Type& formal) {
  Argument a;
  a.place = place(e);
  const Type type = e->type;
  const bool isAlike =
      formal.base == Base::Void || formal.base == type.base || (isTriple(formal.base) && isTriple(type.base));
  if (a.place.isWhole() && isAlike) {
    a.symbol = a.place.symbol;
    return a;
  }
  Type copy = formal.base == Base::Void ? type : formal;
  if (copy.arrayLength < 0) copy.arrayLength = type.arrayLength;
  a.symbol = temporary(copy, e->pos);
  assign(a.symbol, load(a.place, e->pos), e->pos);
  a.isStoredBack = true;
  return a;
}

SymbolId Lowerer::call(Expr* e, SymbolId want) {
  if (e->isStructConstruct) {
    const SymbolId t = temporary(e->type, e->pos);
    fillList(e, t);
    return t;
  }
  if (e->builtin) return builtin(e, want);
  if (e->function->isClosure) return closure(e->function, e);
  return inlined(e->function, e->list, {}, e->pos);
}

namespace {

// Whether a return stands anywhere but at the very end.
bool leaves(const Stmt* s, bool isLast) {
  if (!s) return false;
  switch (s->kind) {
    case StmtKind::Return:
      return !isLast;
    case StmtKind::If:
      return leaves(s->body, isLast) || leaves(s->other, isLast);
    case StmtKind::While:
    case StmtKind::DoWhile:
    case StmtKind::For:
      return leaves(s->body, false);
    case StmtKind::Block:
      for (size_t i = 0; i < s->list.size(); ++i)
        if (leaves(s->list[i], isLast && i + 1 == s->list.size())) return true;
      return false;
    default:
      return false;
  }
}

bool leavesEarly(Function* f) {
  if (f->early < 0) f->early = leaves(f->body, true);
  return f->early != 0;
}

}  // namespace

// `values`: what the arguments are, where that is known already.
SymbolId Lowerer::inlined(Function* f, std::span<Expr*> arguments, std::span<const SymbolId> values, Pos pos) {
  if (f->definition) f = f->definition;
  const std::string name(names_.text(f->name));
  if (!f->body) messages_.fatal(pos, "function '" + name + "' is declared but not defined");
  if (f->isActive) messages_.fatal(pos, "function '" + name + "' calls itself; recursion is not possible");
  const Deeper deeper(*this, pos);
  const Pos* const outer = libraryCall_;
  std::vector<Argument> outputs;
  std::vector<SymbolId> bound;
  for (size_t i = 0; i < arguments.size(); ++i) {
    const Var* p = f->parameters[i];
    if (p->kind == VarKind::OutputArgument) {
      outputs.push_back(output(arguments[i], p->type));
      bound.push_back(outputs.back().symbol);
      continue;
    }
    SymbolId v = converted(i < values.size() ? values[i] : value(arguments[i]), p->type, arguments[i]->pos);
    if (p->isWritten) {  // a copy of its own
      const SymbolId copy = temporary(typeOf(v), arguments[i]->pos);
      assign(copy, v, arguments[i]->pos);
      v = copy;
    }
    bound.push_back(v);
  }
  for (size_t i = 0; i < bound.size(); ++i) f->parameters[i]->id = bound[i];
  if (f->isPrelude && !libraryCall_) libraryCall_ = &pos;

  f->isActive = true;
  const SymbolId result = f->type.base == Base::Void ? kNone : temporary(f->type, pos);
  frames_.push_back({f, result});
  if (leavesEarly(f)) {
    Block body = block(pos, [&] { statements(f->body->list, true); });
    Instruction& i = emit(Opcode::Call, {constant(name)}, pos);
    i.blocks.push_back(std::move(body));
  } else {
    statements(f->body->list, true);
  }
  frames_.pop_back();
  f->isActive = false;
  libraryCall_ = outer;
  for (const Argument& a : outputs)
    if (a.isStoredBack) store(a.place, a.symbol, pos);
  return result == kNone ? constant(0) : result;
}

SymbolId Lowerer::closure(Function* f, Expr* e) {
  std::vector<SymbolId> arguments = {kNone, constant(names_.text(f->name))};
  for (size_t i = 0; i < e->list.size(); ++i) {
    const SymbolId v = value(e->list[i]);
    arguments.push_back(i < f->parameters.size() ? converted(v, f->parameters[i]->type, e->pos) : v);
  }
  const SymbolId t = temporary(e->type, e->pos);
  arguments[0] = t;
  emit(Opcode::MakeClosure, std::move(arguments), e->pos);
  return t;
}

SymbolId Lowerer::builtin(Expr* e, SymbolId want) {
  const Builtin& b = *e->builtin;
  const Signature& s = *e->signature;
  Opcode op = b.opcode;
  if (op == Opcode::TransformPoint && s.result.base == Base::Vector) op = Opcode::TransformVector;
  if (op == Opcode::TransformPoint && s.result.base == Base::Normal) op = Opcode::TransformNormal;

  std::vector<SymbolId> arguments;
  std::vector<Argument> outputs;
  const bool hasResult = s.result.base != Base::Void;
  if (hasResult) arguments.push_back(kNone);
  if (op == Opcode::MakeClosure) arguments.push_back(constant(b.name));
  for (uint32_t i = 0; i < e->list.size(); ++i) {
    const Formal f = s.at(i);
    Expr* x = e->list[i];
    const bool isOptional = s.rest == '@' && i > s.count && (i - s.count) % 2 == 1 && op != Opcode::MakeClosure &&
                            e->list[i - 1]->kind == ExprKind::String &&
                            (e->list[i - 1]->text == "alpha" || e->list[i - 1]->text == "errormessage");
    const bool isData = op == Opcode::PointCloudSearch && i >= s.count && x->type.arrayLength != 0;
    if (f.isOutput || isOptional || (isData && x->kind == ExprKind::Variable)) {
      outputs.push_back(output(x, f.isAny ? Type{} : f.type));
      arguments.push_back(outputs.back().symbol);
      continue;
    }
    const SymbolId v = x->kind == ExprKind::List ? list(x, kNone) : value(x);
    arguments.push_back(f.isAny ? v : converted(v, f.type, x->pos));
  }

  switch (op) {
    case Opcode::MakeClosure:
      // The language's header makes short forms of long ones, which is what a print shows: perfect mirrors of index 0,
      // microfacets without a direction and alike in both.
      if (b.name == "reflection" && s.count == 1) arguments.insert(arguments.begin() + 3, constant(0.f));
      if (b.name == "microfacet" && s.count == 5) {
        const SymbolId alpha = arguments[4];
        arguments.insert(arguments.begin() + 4, {converted(constant(0.f), {Base::Vector, 0, -1}, e->pos), alpha});
      }
      break;
    case Opcode::ArrayLength:
      if (const int32_t n = typeOf(arguments[1]).arrayLength; n > 0) return constant(n);
      break;
    case Opcode::IsConnected:
      while (typeOf(arguments[1]).base == Base::Struct) ++arguments[1];  // as its first field is
      // a function's argument may be anything
      if (const SymbolKind kind = out_.symbols[size_t(arguments[1])].kind;
          kind != SymbolKind::Param && kind != SymbolKind::OutputParam)
        return constant(0);
      break;
    case Opcode::FaceForward:
      if (arguments.size() == 3) {
        arguments.push_back(globalNg());
      }
      break;
    case Opcode::Substr:
      if (arguments.size() == 3) {
        const SymbolId length = temporary({Base::Int, 0, -1}, e->pos);
        emit(Opcode::Strlen, {length, arguments[1]}, e->pos);
        arguments.push_back(length);
      }
      break;
    case Opcode::Rotate:
      if (arguments.size() == 5) {  // about the line through two points
        const Type vector{Base::Vector, 0, -1};
        const SymbolId axis = temporary(vector, e->pos), from = temporary(vector, e->pos),
                       turned = temporary(vector, e->pos);
        emit(Opcode::Sub, {axis, arguments[4], arguments[3]}, e->pos);
        emit(Opcode::Sub, {from, arguments[1], arguments[3]}, e->pos);
        emit(Opcode::Rotate, {turned, from, arguments[2], axis}, e->pos);
        const SymbolId t = result(s.result, want, e->pos);
        emit(Opcode::Add, {t, turned, arguments[3]}, e->pos);
        return t;
      }
      break;
    default:
      break;
  }
  SymbolId t = kNone;
  if (hasResult) {
    // x = getattribute(name, x): the result may not stand where the output stands
    for (const Argument& a : outputs)
      if (a.symbol == want) want = kNone;
    t = result(s.result, want, e->pos);
    arguments[0] = t;
  }
  emit(op, std::move(arguments), e->pos);
  for (const Argument& a : outputs)
    if (a.isStoredBack) store(a.place, a.symbol, e->pos);
  return t == kNone ? constant(0) : t;
}

}  // namespace kinora::language::front
