// A checked tree to the intermediate form. Functions are inlined: arguments are bound by reference where they are
// values of the same type, through a copy where not. Called by compile() when there was no error; what it still
// refuses is recursion through prototypes and sizes beyond its limits.
#pragma once
#include <string>
#include <unordered_map>

#include "language/front/ast.h"
#include "language/front/builtins.h"

namespace kinora::language::front {

class Lowerer {
 public:
  Lowerer(std::vector<Structure> structures, const Names& names, Messages& messages);
  Shader run(ShaderDecl* decl);

 private:
  // Where a value is kept: a symbol, an element of it, a component of that.
  struct Place {
    SymbolId symbol = kNone;
    Type type;
    SymbolId element = kNone, component = kNone, column = kNone;
    bool isWhole() const { return element == kNone && component == kNone; }
  };
  struct Frame {  // the function being inlined; the shader itself at the bottom
    Function* function = nullptr;
    SymbolId result = kNone;
  };

  // lower.cpp: symbols, places, statements
  SymbolId addSymbol(std::string name, SymbolKind kind, Type type, Pos pos);
  SymbolId temporary(Type type, Pos pos) {
    return addSymbol("$tmp" + std::to_string(temporaries_++), SymbolKind::Temp, type, pos);
  }
  SymbolId constant(const Type& type, Values values);
  SymbolId constant(int32_t i);
  SymbolId constant(float f);
  SymbolId constant(std::string_view s);
  SymbolId unset(const Type& type);  // the empty strings of a variable that was never set
  SymbolId symbolOf(Var* v);
  SymbolId globalNg();
  size_t sizeOf(const Type& type) const;  // symbols that a value takes
  SymbolId fieldOf(SymbolId structure, int32_t field) const;
  Type typeOf(SymbolId id) const { return out_.symbols[size_t(id)].type; }
  Instruction& emit(Opcode op, std::vector<SymbolId> arguments, Pos pos);
  template <class F>
  Block block(Pos pos, F&& fill);

  void parameter(Var* v, SymbolId id, const Type& type, Expr* init);
  void initialiser(Var* v, SymbolId id, const Type& type, Expr* init, const std::vector<int32_t>& path);
  std::vector<Metadata> metadata(std::span<MetaDecl> list);
  void statement(Stmt* s, bool isLast);
  void statements(std::span<Stmt*> list, bool isLast);
  void local(Var* v);
  void loop(Stmt* s);
  void giveBack(Stmt* s, bool isLast);

  // lower_expression.cpp
  SymbolId value(Expr* e, SymbolId want = kNone);
  void effects(Expr* e);  // the value is not needed
  SymbolId condition(Expr* e);
  SymbolId truth(SymbolId v, Pos pos);
  SymbolId result(const Type& type, SymbolId want, Pos pos);
  SymbolId converted(SymbolId v, const Type& to, Pos pos);
  void assign(SymbolId to, SymbolId from, Pos pos);
  Place place(Expr* e);
  SymbolId load(const Place& p, Pos pos);
  void store(const Place& p, SymbolId v, Pos pos);
  void storeElement(SymbolId array, SymbolId element, SymbolId v, Pos pos);
  SymbolId binary(Expr* e, SymbolId a, SymbolId b, SymbolId want);
  SymbolId logical(Expr* e);
  SymbolId ternary(Expr* e, SymbolId want);
  SymbolId assignment(Expr* e);
  SymbolId increment(Expr* e, bool isUsed);
  SymbolId construct(Expr* e, Base base, SymbolId want);
  SymbolId list(Expr* e, SymbolId want);
  void fillList(Expr* e, SymbolId into);

  // lower_call.cpp
  struct Argument {
    SymbolId symbol = kNone;
    bool isStoredBack = false;
    Place place;
  };
  Argument output(Expr* e, const Type& formal);
  SymbolId call(Expr* e, SymbolId want);
  SymbolId inlined(Function* f, std::span<Expr*> arguments, std::span<const SymbolId> values, Pos pos);
  SymbolId closure(Function* f, Expr* e);
  SymbolId builtin(Expr* e, SymbolId want);

  struct Deeper;

  Shader out_;
  const Names& names_;
  Messages& messages_;
  Block* block_ = nullptr;
  std::vector<Frame> frames_;
  std::unordered_map<std::string, SymbolId> constants_;
  std::unordered_map<int32_t, SymbolId> unset_;  // by the length of an array
  std::vector<SymbolId> globals_;
  size_t temporaries_ = 0, constantCount_ = 0, locals_ = 0, instructions_ = 0, values_ = 0;
  uint32_t depth_ = 0, blocks_ = 0;
  const Pos* libraryCall_ = nullptr;  // where the shader calls the function of the library that is being inlined
};

constexpr uint32_t kMostLowered = 1500;  // expressions and statements inside each other, through calls
struct Lowerer::Deeper {
  Deeper(Lowerer& l, Pos pos) : l_(l) {
    if (++l.depth_ > kMostLowered) l.messages_.fatal(pos, "calls and expressions are nested too deeply");
  }
  ~Deeper() { --l_.depth_; }
  Lowerer& l_;
};

// The code that `fill` makes, as a block of its own.
template <class F>
Block Lowerer::block(Pos pos, F&& fill) {
  if (++blocks_ > 400) messages_.fatal(pos, "conditions and loops are nested too deeply, functions included");
  Block inner;
  Block* const outer = block_;
  block_ = &inner;
  fill();
  block_ = outer;
  --blocks_;
  return inner;
}

}  // namespace kinora::language::front
