// Proves that .oso text that is not whole or not sensible is refused with one message and its line, and that what our
// own writer writes is read back to a program with the same values. Files of other compilers are not at hand here.
#include "language/program/oso_reader.h"

#include "language/program/oso_writer.h"
#include "language/vm/test_runner.h"

namespace kinora::language {
namespace {
using namespace testing;

const std::string kGood = R"(OpenShadingLanguage 1.00
# Compiled by hand
surface good	%meta{string,help,"a, \"b\""}
param	float	Kd	1		%meta{float,min,0}  %read{0,0} %write{2147483647,-1}
oparam	color	result	0 0 0	%write{0,1}
param	string	name	"tab\there"
global	float	u
temp	int	$t1
const	float	$c1	0.5
code ___main___
	mul	result Kd u 	%filename{"good.osl"} %line{3} %argrw{"wrr"}
	gt	$t1 u $c1
	if	$t1 4 5
	assign	result $c1
	nop
	end
)";

std::string errorOf(std::string text) {
  Shader shader;
  std::string error;
  EXPECT_FALSE(readOso(text, "x.oso", shader, error));
  return error;
}
std::string with(const std::string& from, const std::string& to) {
  std::string text = kGood;
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(OsoReader, ReadsWhatIsWhole) {
  Shader shader;
  std::string error;
  ASSERT_TRUE(readOso(kGood, "x.oso", shader, error)) << error;
  EXPECT_EQ(shader.name, "good");
  EXPECT_EQ(shader.metadata.at(0).values.strings.at(0), "a, \"b\"");
  EXPECT_EQ(shader.symbols.at(2).values.strings.at(0), "tab\there");
  ASSERT_EQ(shader.main.code.size(), 3u);
  EXPECT_EQ(shader.main.code[0].pos.str(), "good.osl:3");
  EXPECT_EQ(shader.main.code[2].blocks.at(0).code.size(), 1u);
}

// Other compilers assign whole arrays by `assign`.
TEST(OsoReader, ArraysAreAssignedWhole) {
  Shader shader;
  std::string error;
  ASSERT_TRUE(readOso(R"(OpenShadingLanguage 1.00
shader whole
param	float[3]	from	1 2 3
oparam	float[3]	to	0 0 0
oparam	string[2]	words	"" ""
const	string[2]	$c1	"a" "b"
code ___main___
	assign	to from
	assign	words $c1
	end
)",
                      "x.oso", shader, error))
      << error;
  ASSERT_EQ(shader.main.code.size(), 2u);
  EXPECT_EQ(shader.main.code[0].opcode, Opcode::ArrayCopy);
  Shader mixed;
  EXPECT_FALSE(readOso(R"(OpenShadingLanguage 1.00
shader whole
param	float[3]	from	1 2 3
oparam	float	to	0
code ___main___
	assign	to from
	end
)",
                       "x.oso", mixed, error));
}

TEST(OsoReader, RefusesWhatIsNot) {
  const struct {
    std::string text, message;
  } cases[] = {
      {"", "not an .oso file"},
      {"hello", "not an .oso file"},
      {with("1.00", "2.00"), "x.oso:1: error: version 2.00"},
      {kGood.substr(0, 60), "truncated"},
      {kGood.substr(0, kGood.size() - 5), "no `end`"},
      {with("\tend", ""), "no `end`"},
      {with("$t1 4 5", "$t1 4 99"), "leaves its block"},
      {with("$t1 4 5", "$t1 1 5"), "leaves its block"},
      {with("$t1 4 5", "$t1"), "`if` lacks its jumps"},
      {with("\tgt\t", "\tgone\t"), "operation `gone` is not known"},
      {with("gt\t$t1 u $c1", "gt\t$t1 u"), "has 2 arguments"},
      {with("Kd u", "Kd nothing"), "`nothing` is no symbol"},
      {with("float\tKd\t1", "float[99999999]\tKd\t1"), "array length"},
      {with("float\tKd\t1", "float\tKd\t1 2"), "more values than"},
      {with("float\tKd\t1", "float\tKd\tabc"), "no value for `Kd`"},
      {with("float\tKd\t1", "flout\tKd\t1"), "`flout` is no type"},
      {with("\"tab\\there\"", "\"tab"), "a string has no end"},
      {with("global\tfloat\tu", "global\tfloat\tKd"), "stands twice"},
      {with("$c1\t0.5", "$c1"), "has no value"},
      {with("temp\tint\t$t1", "temp\tstring\t$t1"), "error"},
  };
  for (const auto& c : cases)
    EXPECT_NE(errorOf(c.text).find(c.message), std::string::npos)
        << "wanted: " << c.message << "\ngot: " << errorOf(c.text);
  // every beginning of a file is refused or read, and none is a fault
  for (size_t n = 0; n < kGood.size(); ++n) {
    Shader shader;
    std::string error;
    const bool isRead = readOso(kGood.substr(0, n), "x.oso", shader, error);
    EXPECT_EQ(isRead, error.empty());
  }
}

TEST(OsoReader, ReadsWhatOurWriterWrites) {
  for (const char* text : {"shader a(float k = 2, output float r = 0) { for (int i = 0; i < 5; i++) { if (i > u * 5) "
                           "continue; r += v * k; } do { r += 1; } while (r < 3); }",
                           "struct S { float a; color b; }; shader a(S s = {1, 2}, float q[] = {3, 4}, float z = "
                           "sin(s.a), output float r = 0) { float f(float x) { if (x > 0.5) return 1; return x; } r "
                           "= f(u) + s.b[1] + q[1] + z + noise(\"cell\", P); }"}) {
    const auto shader = shaderOf(text);
    ShaderGroup group;
    group.layers.push_back({shader, "layer", {}});
    group.outputs = {"r"};
    const Answer own = runEverywhere(group), read = runEverywhere(groupOf(osoText(*shader), {"r"}));
    EXPECT_EQ(own.values.at("r"), read.values.at("r")) << text;
  }
}

}  // namespace
}  // namespace kinora::language
