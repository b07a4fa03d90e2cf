// SeExpr to source of the shading language, which the front end then compiles: so that expressions run on the group
// machine, flattened into one program with the shaders about them. Called for PxrSeExpr nodes. It reads no files and
// keeps nothing; what it makes is bounded, and there are no loops or functions in an expression that could run on.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace kinora::language::seexpr {

// What a node gives besides its expression: variables of the expression.
struct Input {
  std::string name;
  bool isTriple = false;  // else a number
};

// The parameter of the made shader that stands for an input: inputs may be named like functions.
std::string parameterOf(const std::string& input);

struct Translation {
  std::string source;               // a shader with outputs resultRGB, resultR, resultG, resultB and resultF
  std::vector<std::string> inputs;  // names of those that the expression uses
  std::string problem;              // "LINE:COLUMN: why there is no source", else ""
};
Translation translate(std::string_view expression, const std::vector<Input>& inputs, const std::string& shaderName);

}  // namespace kinora::language::seexpr
