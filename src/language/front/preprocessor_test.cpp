// Macros, conditions and includes, by what is left of a source after them.
#include <gtest/gtest.h>

#include "language/front/test_support.h"

namespace kinora::language {
namespace {

// The tokens of the preprocessed text, one space between them, without line markers.
std::string after(const std::string& source, const std::map<std::string, std::string>& files = {},
                  const CompileOptions& options = {}) {
  const PreprocessResult r =
      preprocess(source, "t.osl", options, [&](const std::string& path) -> std::optional<std::string> {
        const auto at = files.find(path);
        return at == files.end() ? std::nullopt : std::optional(at->second);
      });
  EXPECT_TRUE(r.isOk) << (r.messages.empty() ? "" : r.messages[0].str());
  std::string out;
  for (size_t at = 0; at < r.text.size();) {
    const size_t end = std::min(r.text.find('\n', at), r.text.size());
    const std::string line = r.text.substr(at, end - at);
    at = end + 1;
    if (line.starts_with("#")) continue;
    for (const char c : line)
      if (c != ' ' || (!out.empty() && out.back() != ' ')) out += c;
    if (!out.empty() && out.back() != ' ') out += ' ';
  }
  while (!out.empty() && out.back() == ' ') out.pop_back();
  return out;
}

TEST(Preprocessor, Objects) {
  EXPECT_EQ(after("#define A 1 + B\n#define B 2\nA"), "1 + 2");
  EXPECT_EQ(after("#define A A + 1\nA"), "A + 1");
  EXPECT_EQ(after("#define A B\n#define B A\nA B"), "A B");
  EXPECT_EQ(after("#define A 1\n#undef A\nA"), "A");
  EXPECT_EQ(after("#define A\nx A y"), "x y");
  EXPECT_EQ(after("#define A 1 \\\n  + 2\nA"), "1 + 2");
}

TEST(Preprocessor, Functions) {
  EXPECT_EQ(after("#define F(x, y) ((x) * (y))\nF(1, F(2, 3))"), "( ( 1 ) * ( ( ( 2 ) * ( 3 ) ) ) )");
  EXPECT_EQ(after("#define F(x) x\nF ((1, 2)) F"), "( 1 , 2 ) F");
  EXPECT_EQ(after("#define F() 7\nF() F"), "7 F");
  EXPECT_EQ(after("#define F(x) #x\nF(a  + \"b\\n\")"), "\"a + \\\"b\\\\n\\\"\"");
  EXPECT_EQ(after("#define CAT(a, b) a ## b\nCAT(x, 1) CAT(, y) CAT(z, )"), "x1 y z");
  EXPECT_EQ(after("#define V(f, ...) f(__VA_ARGS__)\nV(a, 1, 2) V(b)"), "a ( 1 , 2 ) b ( )");
  EXPECT_EQ(after("#define V(f, ...) p(f, ## __VA_ARGS__)\nV(a) V(b, 1)"), "p ( a ) p ( b , 1 )");
  EXPECT_EQ(after("#define F(x) x\n#define G F\nG(1)\nF\n(2)"), "1 2");
  EXPECT_EQ(after("#define N(x) Texture_ ## x ## _Name\nN(Bump)"), "Texture_Bump_Name");
  EXPECT_EQ(after("#define M(x) #x \".page\"\nM(Spec)"), "\"Spec\" \".page\"");
  // the example of the C standard (6.10.3.5), in part
  EXPECT_EQ(after("#define x 3\n#define f(a) f(x * (a))\n#undef x\n#define x 2\n#define g f\n#define z z[0]\n"
                  "#define t(a) a\nt(t(g)(0) + t)(1);"),
            "f ( 2 * ( 0 ) ) + t ( 1 ) ;");
}

TEST(Preprocessor, Conditions) {
  EXPECT_EQ(after("#if 0\na\n#elif 1\nb\n#else\nc\n#endif"), "b");
  EXPECT_EQ(after("#ifdef X\na\n#else\nb\n#endif\n#ifndef X\nc\n#endif"), "b c");
  EXPECT_EQ(after("#if 0\n#if 1\na\n#else\nb\n#endif\n\"it's\n#endif\nc"), "c");
  EXPECT_EQ(after("#define A 3\n#if defined(A) && A * 2 == 6 && !defined B\nyes\n#endif"), "yes");
  EXPECT_EQ(after("#if (1 ? 2 : 3) == 2 && -1 < 0 && (7 / 2) == 3 && ~0 == -1\nyes\n#endif"), "yes");
  EXPECT_EQ(after("#if 1 / 0 == 0 && UNKNOWN == 0 && 0x10 == 16\nyes\n#endif"), "yes");
  EXPECT_EQ(after("#define F(x) x\n#if F(1)\nyes\n#endif"), "yes");
  EXPECT_EQ(after("#if OSL_VERSION >= 11400 && OSL_VERSION_MAJOR == 1\nyes\n#endif"), "yes");
}

TEST(Preprocessor, Includes) {
  const std::map<std::string, std::string> files = {{"a.h", "a1\n#include \"sub/b.h\"\na2\n"},
                                                    {"sub/b.h", "b\n#include \"c.h\"\n"},
                                                    {"sub/c.h", "c\n"},
                                                    {"path/d.h", "d\n"}};
  CompileOptions options;
  EXPECT_EQ(after("#include \"a.h\"\nend", files), "a1 b c a2 end");
  options.includePaths = {"nowhere", "path"};
  EXPECT_EQ(after("#include <d.h>\n#include \"d.h\"", files, options), "d d");
  EXPECT_EQ(after("#define NAME \"a.h\"\n#include NAME\n", files), "a1 b c a2");
  EXPECT_EQ(after("#include \"stdosl.h\"\n#include <stdosl.h>\nx"), "x");
  const PreprocessResult r = preprocess("#include \"a.h\"\n", "t.osl", {}, [&](const std::string& p) {
    const auto at = files.find(p);
    return at == files.end() ? std::nullopt : std::optional(at->second);
  });
  EXPECT_EQ(r.files, (std::vector<std::string>{"t.osl", "a.h", "sub/b.h", "sub/c.h"}));
}

TEST(Preprocessor, LinesFilesAndOptions) {
  EXPECT_EQ(after("\n\n__LINE__ __FILE__"), "3 \"t.osl\"");
  EXPECT_EQ(after("#define L __LINE__\n\nL"), "3");
  CompileOptions options;
  options.defines = {"A=7", "B", "C=x y"};
  options.undefines = {"B"};
  EXPECT_EQ(after("A B C", {}, options), "7 B x y");
  EXPECT_EQ(after("a /* x \n y */ b // c \\\n d\ne"), "a b e");
  EXPECT_EQ(after("\xef\xbb\xbf"
                  "a"),
            "a");
  EXPECT_EQ(after("# 12 \"other.osl\"\na"), "a");
}

TEST(Preprocessor, WarningsOfTheSource) {
  const Compiled c =
      compiled("#warning be careful\n#pragma osl something\n#pragma warning \"twice\"\nshader t() { }\n");
  EXPECT_TRUE(c.result.ok());
  EXPECT_EQ(c.warnings, "1:2 #warning be careful\n3:2 #warning twice\n");
  EXPECT_TRUE(compiled("#define A 1\n#define A 2\nshader t() { }").says("macro 'A' is defined again"));
  EXPECT_EQ(compiled("#define A 1\n#define A 1\nshader t() { }").warnings, "");
  EXPECT_EQ(compiled("shader t() {\n#pragma osl nowarn\n  int i = 1.5;\n  int k = 2.5;\n}").warnings.substr(0, 2),
            "4:");
}

}  // namespace
}  // namespace kinora::language
