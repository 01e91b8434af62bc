#include "cx/protobuf/wire.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cassert>

namespace cxlab::pb {

namespace {

constexpr std::uint8_t kVersion = 2;
constexpr std::size_t kIv = 16;
constexpr int kKeyRounds = 8;
constexpr std::array<std::string_view, 5> kCiphers{"none", "aes-128-ecb", "aes-128-cbc", "aes-256-ecb", "aes-256-cbc"};

std::uint8_t byte_at(std::string_view bytes, std::size_t i) { return static_cast<std::uint8_t>(bytes[i]); }

std::uint16_t read_u16(std::string_view bytes) {
  return static_cast<std::uint16_t>(byte_at(bytes, 0) << 8 | byte_at(bytes, 1));
}

std::uint32_t read_u32(std::string_view bytes) {
  return static_cast<std::uint32_t>(read_u16(bytes)) << 16 | read_u16(bytes.substr(2));
}

void put_u16(std::string& out, std::uint16_t value) {
  out += static_cast<char>(value >> 8);
  out += static_cast<char>(value & 0xff);
}

void put_u32(std::string& out, std::uint32_t value) {
  put_u16(out, static_cast<std::uint16_t>(value >> 16));
  put_u16(out, static_cast<std::uint16_t>(value & 0xffff));
}

const unsigned char* raw(std::string_view text) { return reinterpret_cast<const unsigned char*>(text.data()); }
unsigned char* raw(std::string& text) { return reinterpret_cast<unsigned char*>(text.data()); }

const EVP_CIPHER* algorithm(Cipher cipher) {
  switch (cipher) {
    case Cipher::kAes128Ecb: return EVP_aes_128_ecb();
    case Cipher::kAes128Cbc: return EVP_aes_128_cbc();
    case Cipher::kAes256Ecb: return EVP_aes_256_ecb();
    case Cipher::kAes256Cbc: return EVP_aes_256_cbc();
    case Cipher::kNone: break;
  }
  return nullptr;
}

std::size_t iv_size(Cipher cipher) { return cipher == Cipher::kAes128Cbc || cipher == Cipher::kAes256Cbc ? kIv : 0; }

struct FrameHeader {
  Cipher cipher{};
  std::size_t payload = 0;
};

/// `bytes` has at least a header.
Expected<FrameHeader> read_header(std::string_view bytes) {
  if (byte_at(bytes, 0) != kVersion)
    return input_error(
        found_expected("frame header version " + std::to_string(byte_at(bytes, 0)), std::to_string(kVersion)));
  if (byte_at(bytes, 1) >= kCiphers.size())
    return input_error(
        found_expected("cipher " + std::to_string(byte_at(bytes, 1)), "0 to " + std::to_string(kCiphers.size() - 1)));
  return FrameHeader{static_cast<Cipher>(byte_at(bytes, 1)), read_u32(bytes.substr(4))};
}

Expected<Frame> read_payload(std::string_view payload) {
  if (payload.size() < kMessageHeader)
    return input_error(found_expected("a payload of " + std::to_string(payload.size()) + " bytes",
                                      "at least " + std::to_string(kMessageHeader)));
  return Frame{{read_u16(payload), read_u16(payload.substr(2))}, std::string(payload.substr(kMessageHeader))};
}

Error wrong_size(std::size_t found, std::size_t expected) {
  return input_error("Invalid number of bytes: " + found_expected(std::to_string(found), std::to_string(expected)));
}

}  // namespace

Expected<Cipher> cipher_of(std::string_view name) {
  for (std::size_t i = 1; i < kCiphers.size(); ++i)
    if (kCiphers[i] == name) return static_cast<Cipher>(i);
  return input_error("Unknown cipher '" + std::string(name) +
                     "', expected aes-128-ecb, aes-128-cbc, aes-256-ecb or aes-256-cbc");
}

// --- Encryption

struct Crypto::Context {
  struct Free {
    void operator()(EVP_CIPHER_CTX* context) const { EVP_CIPHER_CTX_free(context); }
  };
  std::unique_ptr<EVP_CIPHER_CTX, Free> evp{EVP_CIPHER_CTX_new()};
  std::array<unsigned char, EVP_MAX_KEY_LENGTH> key{};
};

Crypto::Crypto(Cipher cipher) : cipher_(cipher), context_(std::make_unique<Context>()) {}
Crypto::~Crypto() = default;

Expected<std::unique_ptr<Crypto>> Crypto::create(Cipher cipher, std::string_view pass_phrase) {
  assert(cipher != Cipher::kNone);
  std::unique_ptr<Crypto> crypto(new Crypto(cipher));
  if (!crypto->context_->evp ||
      EVP_BytesToKey(algorithm(cipher), EVP_sha256(), nullptr, raw(pass_phrase), static_cast<int>(pass_phrase.size()),
                     kKeyRounds, crypto->context_->key.data(), nullptr) == 0)
    return resource_error("OpenSSL cannot make a key for " + std::string(kCiphers[static_cast<std::size_t>(cipher)]));
  return crypto;
}

std::string Crypto::encrypt(std::string_view plain) {
  const std::size_t iv = iv_size(cipher_);
  std::string out(iv + plain.size() + EVP_MAX_BLOCK_LENGTH, '\0');
  if (iv > 0) {
    std::string counter;
    ++count_;
    put_u32(counter, static_cast<std::uint32_t>(count_ >> 32));
    put_u32(counter, static_cast<std::uint32_t>(count_));
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    EVP_Digest(counter.data(), counter.size(), digest.data(), nullptr, EVP_sha256(), nullptr);
    std::copy_n(digest.begin(), iv, out.begin());
  }
  EVP_CIPHER_CTX* evp = context_->evp.get();
  int size = 0, last = 0;
  EVP_EncryptInit_ex(evp, algorithm(cipher_), nullptr, context_->key.data(), raw(out));
  EVP_EncryptUpdate(evp, raw(out) + iv, &size, raw(plain), static_cast<int>(plain.size()));
  EVP_EncryptFinal_ex(evp, raw(out) + iv + size, &last);
  out.resize(iv + static_cast<std::size_t>(size + last));
  return out;
}

Expected<std::string> Crypto::decrypt(std::string_view encrypted) const {
  const std::size_t iv = iv_size(cipher_);
  if (encrypted.size() <= iv)
    return input_error("Decryption failed: " + found_expected(std::to_string(encrypted.size()) + " encrypted bytes",
                                                              "more than " + std::to_string(iv)));
  const std::string_view body = encrypted.substr(iv);
  std::string out(body.size() + EVP_MAX_BLOCK_LENGTH, '\0');
  EVP_CIPHER_CTX* evp = context_->evp.get();
  int size = 0, last = 0;
  EVP_DecryptInit_ex(evp, algorithm(cipher_), nullptr, context_->key.data(), raw(encrypted));
  if (EVP_DecryptUpdate(evp, raw(out), &size, raw(body), static_cast<int>(body.size())) == 0 ||
      EVP_DecryptFinal_ex(evp, raw(out) + size, &last) == 0)
    return input_error("Decryption failed: the bytes were cut, or encrypted with another key");
  out.resize(static_cast<std::size_t>(size + last));
  return out;
}

// --- Frames

std::string write_frame(MessageKey key, std::string_view content, Crypto* crypto) {
  std::string payload;
  payload.reserve(kMessageHeader + content.size());
  put_u16(payload, key.component_id);
  put_u16(payload, key.message_type);
  payload += content;
  if (crypto) payload = crypto->encrypt(payload);
  std::string out;
  out.reserve(kFrameHeader + payload.size());
  out += static_cast<char>(kVersion);
  out += static_cast<char>(crypto ? crypto->cipher() : Cipher::kNone);
  out.append(2, '\0');
  put_u32(out, static_cast<std::uint32_t>(payload.size()));
  return out + payload;
}

Expected<Frame> read_datagram(std::string_view bytes, const Crypto* crypto) {
  if (bytes.size() < kFrameHeader) return wrong_size(bytes.size(), kFrameHeader);
  const auto header = read_header(bytes);
  if (!header) return header.error();
  const std::string_view payload = bytes.substr(kFrameHeader);
  if (header->cipher == Cipher::kNone) {
    if (crypto) return input_error("Received plain text message, but encryption is enabled");
    if (payload.size() != header->payload) return wrong_size(bytes.size(), kFrameHeader + header->payload);
    return read_payload(payload);
  }
  if (!crypto) return input_error("Received encrypted message, but encryption is disabled");
  if (header->cipher != crypto->cipher())
    return input_error("Received message with cipher " +
                       std::string(kCiphers[static_cast<std::size_t>(header->cipher)]) + ", expected " +
                       std::string(kCiphers[static_cast<std::size_t>(crypto->cipher())]));
  // Two readings of the format are in use: with and without the IV.
  const std::size_t iv = iv_size(crypto->cipher());
  if (payload.size() != header->payload && payload.size() != header->payload + iv)
    return wrong_size(bytes.size(), kFrameHeader + header->payload);
  auto plain = crypto->decrypt(payload);
  if (!plain) return plain.error();
  return read_payload(*plain);
}

void StreamReader::add(std::string_view bytes) {
  bytes_.erase(0, read_);
  read_ = 0;
  bytes_ += bytes;
}

Expected<std::optional<Frame>> StreamReader::next() {
  const std::string_view rest = std::string_view(bytes_).substr(read_);
  if (rest.size() < kFrameHeader) return std::optional<Frame>();
  const auto header = read_header(rest);
  if (!header) return header.error();
  if (header->cipher != Cipher::kNone) return input_error("Received encrypted message, but encryption is disabled");
  if (header->payload > kLargestPayload)
    return input_error(found_expected("a payload of " + std::to_string(header->payload) + " bytes",
                                      "at most " + std::to_string(kLargestPayload)));
  if (rest.size() - kFrameHeader < header->payload) return std::optional<Frame>();
  read_ += kFrameHeader + header->payload;
  auto frame = read_payload(rest.substr(kFrameHeader, header->payload));
  if (!frame) return frame.error();
  return std::optional<Frame>(*std::move(frame));
}

}  // namespace cxlab::pb
