// The intermediate form of one shader: symbols and structured code. The front end lowers checked source to it, the
// .oso reader fills it, the optimiser rewrites it, the group machine is generated from it. It is close to the text
// assembly of OSL's own compiler on purpose (reference: osl-numerics, section 12), but control flow is a tree, so
// that a pass never has to find out where a loop ends. Values are not in single-assignment form: a symbol may be
// written many times, and under divergence.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "language/program/opcodes.h"

namespace kinora::language {

enum class Base : uint8_t { Void, Int, Float, String, Color, Point, Vector, Normal, Matrix, Closure, Struct };

// Of an array; a longer one is refused before memory is taken.
inline constexpr int32_t kMostElements = 1 << 20;

struct Type {
  Base base = Base::Void;
  int32_t arrayLength = 0;  // 0: no array; -1: length comes from the instance
  int32_t structure = -1;   // Base::Struct: index into Shader::structures
  friend bool operator==(const Type&, const Type&) = default;
};
constexpr bool isTriple(Base b) { return b >= Base::Color && b <= Base::Normal; }
// Numbers of one element: 1, 3 or 16; 0 for void, closure and struct (whose fields are symbols of their own).
constexpr int32_t componentsOf(Base b) {
  return b == Base::Int || b == Base::Float || b == Base::String ? 1 : isTriple(b) ? 3 : b == Base::Matrix ? 16 : 0;
}
std::string nameOf(const Type&);  // "color", "float[4]", "int[]", "closure color"; a struct is "struct"

struct Field {
  std::string name;
  Type type;
};
struct Structure {
  std::string name;
  std::vector<Field> fields;
};

// Constants, defaults and instance values: one of the lists is used, by the base type. Elements of an array one after
// the other, components inside an element.
struct Values {
  std::vector<int32_t> ints = {};
  std::vector<float> floats = {};
  std::vector<std::string> strings = {};
  bool empty() const { return ints.empty() && floats.empty() && strings.empty(); }
  friend bool operator==(const Values&, const Values&) = default;
};

std::string nineDigits(float);  // as %.9g, from which the same number is read back

struct Metadata {
  std::string name;
  Type type;
  Values values;
};

using SymbolId = int32_t;  // index into Shader::symbols; kNone: no operand
constexpr SymbolId kNone = -1;

// Constants of empty strings whose names begin so are what variables hold that were never set.
inline constexpr std::string_view kUnsetName = "$unset";

enum class SymbolKind : uint8_t { Param, OutputParam, Local, Temp, Global, Constant };

// A value by name. A struct is a symbol without a value (type.base == Struct) followed by a symbol for each field,
// named base.field; code speaks of the fields only, but for structs passed whole to an opcode that takes them.
struct Symbol {
  std::string name;
  SymbolKind kind = SymbolKind::Local;
  Type type;
  Values values;             // Constant: its value. Params: the literal default (zeros where code computes it)
  bool hasInitCode = false;  // Params: Shader::initialisers holds code for the default
  bool lockGeometry = true;  // Params: false: a primvar of that name replaces the value
  std::vector<Metadata> metadata;
  SymbolId ofStruct = kNone;  // this is field `field` of that struct symbol
  int32_t field = -1;
  SourcePos pos;
};

struct Block;

// One operation. `arguments` are results and operands in the order of the opcode table (result first). Blocks, by
// opcode:
//   If              condition; blocks {then, else}
//   For, While,     condition symbol, re-evaluated by block 1; blocks {init, condition, body, step}; unused ones
//   empty. DoWhile         DoWhile runs {init}, then body, step, condition. `continue` goes to step, `break` leaves.
//   Call            an inlined function, blocks {body}; `return` inside it leaves that body. `text` is the function.
struct Instruction {
  Opcode opcode = Opcode::Nop;
  std::vector<SymbolId> arguments;
  std::vector<Block> blocks;
  SourcePos pos;
  int32_t layer = 0;  // of a flattened network: the layer that it comes from
  int32_t name = -1;  // of a flattened network: what messages call the array or triple indexed, FlatProgram::names
};

struct Block {
  std::vector<Instruction> code;
};

enum class ShaderKind : uint8_t { Shader, Surface, Displacement, Volume };

struct Initialiser {
  SymbolId parameter = kNone;
  Block code;  // runs before `main`, in the order of parameters, unless an instance or a connection gives the value
};

struct Shader {
  ShaderKind kind = ShaderKind::Shader;
  std::string name;
  std::vector<Metadata> metadata;
  std::vector<Structure> structures;
  std::vector<Symbol> symbols;  // parameters first, in the order of declaration
  std::vector<Initialiser> initialisers;
  Block main;
  SymbolId find(std::string_view name) const;  // kNone when there is none
};

// accessOf() of opcodes.h, with the outputs that tokens announce, and arrays that are overwritten in part.
char accessOf(const Shader&, const Instruction&, uint32_t argument);

// Every number that other code relies on: symbol ids in range, operand counts and types that the opcode takes, block
// counts, break and continue inside loops, nesting of at most 500. "" or what is wrong. Whoever reads a shader from
// outside calls it before anybody else sees the shader.
std::string invalid(const Shader&);

// The readable form for `kinora shader info --ir`.
std::string toText(const Shader&);

}  // namespace kinora::language
