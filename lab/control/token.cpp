#include "lab/control/token.h"

#include <fstream>

namespace cxlab::lab {

Expected<std::string> new_token() {
  std::ifstream chance("/dev/urandom", std::ios::binary);
  unsigned char bytes[16];
  if (!chance.read(reinterpret_cast<char*>(bytes), sizeof bytes))
    return resource_error("cannot be read", "/dev/urandom");
  std::string token;
  constexpr const char* kDigits = "0123456789abcdef";
  for (const unsigned char byte : bytes) token.append({kDigits[byte >> 4], kDigits[byte & 15]});
  return token;
}

bool same_text(const std::string& a, const std::string& b) {
  if (a.size() != b.size()) return false;
  unsigned char difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

}  // namespace cxlab::lab
