// One fuzzing input for what reads .oso files and runs them: text assembly, or OSL source that is compiled to it
// first. Used by the fuzzer and its short test.
#pragma once
#include <string>
#include <string_view>

namespace kinora::fuzz {

// The .oso of OSL source; text that is .oso already, or does not compile, comes back as it is.
std::string osoOf(std::string_view bytes);

// Reads, writes, reads again, makes machine code (optimised or not, by the text's length) and runs it on some points
// at widths 1 and 8. What is read must be a valid program, whatever was written must be read as the same program, and
// both widths must give the same bits: otherwise the process is aborted. Returns 0 when the text was refused, else 1.
size_t runOsoInput(std::string_view bytes);

}  // namespace kinora::fuzz
