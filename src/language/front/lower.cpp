// Symbols and statements; lower_expression.cpp and lower_call.cpp have the rest.
#include "language/front/lower.h"

#include <algorithm>
#include <cstring>

#include "language/front/checker.h"
#include "language/front/constants.h"

namespace kinora::language::front {

namespace {

constexpr size_t kMostInstructions = 1'000'000, kMostSymbols = 2'000'000;
constexpr size_t kMostConstantValues = 64u << 20;  // numbers in constants and defaults

}  // namespace

Lowerer::Lowerer(std::vector<Structure> structures, const Names& names, Messages& messages)
    : names_(names), messages_(messages), globals_(32, kNone) {
  out_.structures = std::move(structures);
}

size_t Lowerer::sizeOf(const Type& type) const {
  if (type.base != Base::Struct) return 1;
  size_t n = 1;
  for (const Field& f : out_.structures[size_t(type.structure)].fields) n += sizeOf(f.type);
  return n;
}

SymbolId Lowerer::fieldOf(SymbolId structure, int32_t field) const {
  const Structure& s = out_.structures[size_t(typeOf(structure).structure)];
  size_t id = size_t(structure) + 1;
  for (int32_t i = 0; i < field; ++i) id += sizeOf(s.fields[size_t(i)].type);
  return SymbolId(id);
}

// A struct is followed by the symbols of its fields.
SymbolId Lowerer::addSymbol(std::string name, SymbolKind kind, Type type, Pos pos) {
  if (out_.symbols.size() >= kMostSymbols) messages_.fatal(pos, "the shader is too large");
  const auto id = SymbolId(out_.symbols.size());
  Symbol& s = out_.symbols.emplace_back();
  s.name = name;
  s.kind = kind;
  s.type = type;
  s.pos = messages_.sourcePos(pos);
  if (type.base != Base::Struct) return id;
  for (size_t i = 0; i < out_.structures[size_t(type.structure)].fields.size(); ++i) {
    const Field& f = out_.structures[size_t(type.structure)].fields[i];
    Type t = f.type;
    if (type.arrayLength != 0) t.arrayLength = type.arrayLength;
    const SymbolId field = addSymbol(name + "." + f.name, kind, t, pos);
    out_.symbols[size_t(field)].ofStruct = id;
    out_.symbols[size_t(field)].field = int32_t(i);
  }
  return id;
}

SymbolId Lowerer::constant(const Type& type, Values values) {
  std::string key(1, char(type.base));
  const auto add = [&](const void* p, size_t n) { key.append(static_cast<const char*>(p), n); };
  add(&type.arrayLength, sizeof type.arrayLength);
  add(values.ints.data(), values.ints.size() * 4);
  add(values.floats.data(), values.floats.size() * 4);
  for (const std::string& s : values.strings) {
    const size_t n = s.size();
    add(&n, sizeof n);
    key += s;
  }
  const auto [at, isNew] = constants_.emplace(std::move(key), SymbolId(out_.symbols.size()));
  if (!isNew) return at->second;
  const SymbolId id = addSymbol("$const" + std::to_string(constantCount_++), SymbolKind::Constant, type, {});
  values_ += values.ints.size() + values.floats.size() + values.strings.size() * 8;
  if (values_ > kMostConstantValues) messages_.fatal({}, "the shader's constants are too large");
  out_.symbols[size_t(id)].values = std::move(values);
  return id;
}

SymbolId Lowerer::constant(int32_t i) { return constant({Base::Int, 0, -1}, {.ints = {i}}); }
SymbolId Lowerer::constant(float f) { return constant({Base::Float, 0, -1}, {.floats = {f}}); }
SymbolId Lowerer::constant(std::string_view s) {
  return constant({Base::String, 0, -1}, {.strings = {std::string(s)}});
}

SymbolId Lowerer::unset(const Type& type) {
  SymbolId& id = unset_.emplace(type.arrayLength, kNone).first->second;
  if (id == kNone) {
    id = addSymbol(std::string(kUnsetName) + std::to_string(unset_.size() - 1), SymbolKind::Constant, type, {});
    out_.symbols[size_t(id)].values = zeros(type);
  }
  return id;
}

SymbolId Lowerer::symbolOf(Var* v) {
  if (v->kind != VarKind::Global) return v->id;
  SymbolId& id = globals_[v->globalIndex];
  if (id == kNone) id = addSymbol(std::string(names_.text(v->name)), SymbolKind::Global, v->type, {});
  return id;
}

SymbolId Lowerer::globalNg() {
  SymbolId& id = globals_[kGlobalNg];
  if (id == kNone) id = addSymbol("Ng", SymbolKind::Global, {Base::Normal, 0, -1}, {});
  return id;
}

Instruction& Lowerer::emit(Opcode op, std::vector<SymbolId> arguments, Pos pos) {
  if (++instructions_ > kMostInstructions)
    messages_.fatal(pos, "the shader is too large once its functions are inlined");
  Instruction& i = block_->code.emplace_back();
  i.opcode = op;
  i.arguments = std::move(arguments);
  i.pos = messages_.sourcePos(libraryCall_ ? *libraryCall_ : pos);
  return i;
}

std::vector<Metadata> Lowerer::metadata(std::span<MetaDecl> list) {
  std::vector<Metadata> all;
  for (const MetaDecl& m : list) {
    Metadata d;
    d.name = names_.text(m.name);
    d.type = {m.spec.base, 0, -1};
    if (m.spec.isUnsized || m.spec.length) {
      Values length;
      d.type.arrayLength =
          m.spec.length && constantOf(*m.spec.length, length) ? length.ints[0] : m.value->type.arrayLength;
    }
    Values v;
    if (constantOf(*m.value, v)) d.values = front::converted(v, m.value->type, d.type);
    all.push_back(std::move(d));
  }
  return all;
}

// Code that computes the default of `id`, the field that `path` leads to, or the whole when the path is empty.
void Lowerer::initialiser(Var* v, SymbolId id, const Type& type, Expr* init, const std::vector<int32_t>& path) {
  if (type.base == Base::Struct) {
    const auto n = int32_t(out_.structures[size_t(type.structure)].fields.size());
    for (int32_t i = 0; i < n; ++i) {
      std::vector<int32_t> further = path;
      further.push_back(i);
      const SymbolId field = fieldOf(id, i);
      initialiser(v, field, typeOf(field), init, further);
    }
    return;
  }
  out_.symbols[size_t(id)].hasInitCode = true;
  Initialiser code;
  code.parameter = id;
  code.code = block(init->pos, [&] {
    SymbolId from = value(init, path.empty() ? id : kNone);
    for (const int32_t i : path) from = fieldOf(from, i);
    assign(id, from, init->pos);
  });
  out_.initialisers.push_back(std::move(code));
}

void Lowerer::parameter(Var* v, SymbolId id, const Type& type, Expr* init) {
  const bool isList = init->kind == ExprKind::List || (init->kind == ExprKind::Call && init->isStructConstruct);
  if (type.base == Base::Struct && type.arrayLength == 0 && isList) {
    for (size_t i = 0; i < init->list.size(); ++i) {
      const SymbolId field = fieldOf(id, int32_t(i));
      parameter(v, field, typeOf(field), init->list[i]);
    }
    // what the list leaves out is zero
    for (auto s = size_t(fieldOf(id, int32_t(init->list.size()))); s < size_t(id) + sizeOf(type); ++s)
      if (componentsOf(out_.symbols[s].type.base)) out_.symbols[s].values = zeros(out_.symbols[s].type);
    return;
  }
  if (type.base == Base::Struct) return initialiser(v, id, type, init, {});
  Values values;
  if (type.base == Base::Closure) {
    if (init->kind != ExprKind::Int) initialiser(v, id, type, init, {});
    return;
  }
  const bool isConstant = constantOf(*init, values);
  if (isConstant) {
    values = front::converted(values, init->type, type);
    if (type.arrayLength < 0 && init->list.empty() && init->kind == ExprKind::List)
      values = zeros({type.base, 1, -1});
  } else {
    if (type.arrayLength < 0) messages_.error(init->pos, "the default of an array without a length must be constant");
    values = zeros(type);
  }
  values_ += values.ints.size() + values.floats.size() + values.strings.size() * 8;
  if (values_ > kMostConstantValues) messages_.fatal(init->pos, "the shader's defaults are too large");
  out_.symbols[size_t(id)].values = std::move(values);
  if (!isConstant && type.arrayLength >= 0) initialiser(v, id, type, init, {});
}

Shader Lowerer::run(ShaderDecl* decl) {
  out_.kind = decl->kind;
  out_.name = names_.text(decl->name);
  out_.metadata = metadata(decl->metadata);
  frames_.push_back({});
  for (Var* p : decl->parameters) {
    p->id =
        addSymbol(std::string(names_.text(p->name)),
                  p->kind == VarKind::OutputParameter ? SymbolKind::OutputParam : SymbolKind::Param, p->type, p->pos);
    std::vector<Metadata> all = metadata(p->metadata);
    bool isLocked = true;
    for (const Metadata& m : all) {
      const bool isOne = m.type == Type{Base::Int, 0, -1} && !m.values.ints.empty();
      if (m.name == "lockgeom" && isOne) isLocked = m.values.ints[0] != 0;
      if (m.name == "interpolated" && isOne && m.values.ints[0] != 0) isLocked = false;
    }
    for (size_t i = 0; i < sizeOf(p->type); ++i) out_.symbols[size_t(p->id) + i].lockGeometry = isLocked;
    out_.symbols[size_t(p->id)].metadata = std::move(all);
  }
  for (Var* p : decl->parameters) parameter(p, p->id, p->type, p->init);
  out_.main = block(decl->pos, [&] { statements(decl->body->list, true); });
  return std::move(out_);
}

void Lowerer::statements(std::span<Stmt*> list, bool isLast) {
  for (size_t i = 0; i < list.size(); ++i) statement(list[i], isLast && i + 1 == list.size());
}

void Lowerer::local(Var* v) {
  v->id = addSymbol("___" + std::to_string(++locals_) + "_" + std::string(names_.text(v->name)), SymbolKind::Local,
                    v->type, v->pos);
  const SymbolId id = v->id;
  if (v->init) {
    // a variable that nobody has read yet: lists may be built in place
    assign(id, v->init->kind == ExprKind::List ? list(v->init, id) : value(v->init, id), v->pos);
    return;
  }
  // strings and closures begin as nothing, everything else as it happens to be
  for (size_t i = 0; i < sizeOf(v->type); ++i) {
    const SymbolId s = id + SymbolId(i);
    const Type t = typeOf(s);
    if (t.base == Base::Closure && t.arrayLength == 0) emit(Opcode::Assign, {s, constant(0)}, v->pos);
    if (t.base == Base::String && t.arrayLength == 0) emit(Opcode::Assign, {s, unset(t)}, v->pos);
    if (t.base == Base::String && t.arrayLength > 0) emit(Opcode::ArrayCopy, {s, unset(t)}, v->pos);
  }
}

void Lowerer::loop(Stmt* s) {
  const bool isDo = s->kind == StmtKind::DoWhile;
  SymbolId test = kNone;
  Block init = block(s->pos, [&] {
    if (s->init) statement(s->init, false);
  });
  Block condition = block(s->pos, [&] { test = s->expr ? this->condition(s->expr) : constant(1); });
  Block body = block(s->pos, [&] { statement(s->body, false); });
  Block step = block(s->pos, [&] {
    if (s->step) effects(s->step);
  });
  Instruction& i = emit(isDo                         ? Opcode::DoWhile
                        : s->kind == StmtKind::While ? Opcode::While
                                                     : Opcode::For,
                        {test}, s->pos);
  i.blocks.reserve(4);
  i.blocks.push_back(std::move(init));
  i.blocks.push_back(std::move(condition));
  i.blocks.push_back(std::move(body));
  i.blocks.push_back(std::move(step));
}

// A return at the very end of a body only gives the value; any other leaves the body.
void Lowerer::giveBack(Stmt* s, bool isLast) {
  if (s->expr) {
    const SymbolId result = frames_.back().result;
    assign(result, value(s->expr, typeOf(result).base == Base::Struct ? kNone : result), s->pos);
  }
  if (isLast) return;
  emit(Opcode::Return, {}, s->pos);
}

void Lowerer::statement(Stmt* s, bool isLast) {
  const Deeper deeper(*this, s->pos);
  switch (s->kind) {
    case StmtKind::Empty:
    case StmtKind::Function:
    case StmtKind::Struct:
      break;
    case StmtKind::Expression:
      effects(s->expr);
      break;
    case StmtKind::Block:
      statements(s->list, isLast);
      break;
    case StmtKind::Variables:
      for (Var* v : s->vars) local(v);
      break;
    case StmtKind::If: {
      const SymbolId test = condition(s->expr);
      Block then = block(s->pos, [&] { statement(s->body, isLast); });
      Block other = block(s->pos, [&] {
        if (s->other) statement(s->other, isLast);
      });
      Instruction& i = emit(Opcode::If, {test}, s->pos);
      i.blocks.reserve(2);
      i.blocks.push_back(std::move(then));
      i.blocks.push_back(std::move(other));
      break;
    }
    case StmtKind::While:
    case StmtKind::DoWhile:
    case StmtKind::For:
      loop(s);
      break;
    case StmtKind::Break:
      emit(Opcode::Break, {}, s->pos);
      break;
    case StmtKind::Continue:
      emit(Opcode::Continue, {}, s->pos);
      break;
    case StmtKind::Return:
      giveBack(s, isLast);
      break;
  }
}

}  // namespace kinora::language::front
