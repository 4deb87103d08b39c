#include "trust/guard/documents.h"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509v3.h>

#include <filesystem>
#include <fstream>

namespace rubicon::trust::guard {

namespace {

std::string content_of(BIO* bio) {
  char* text = nullptr;
  const auto length = BIO_get_mem_data(bio, &text);
  std::string content(text, static_cast<std::size_t>(length));
  BIO_free(bio);
  return content;
}

void add_extension(X509* certificate, int nid, const std::string& value) {
  if (value.empty()) return;
  X509V3_CTX context;
  X509V3_set_ctx(&context, certificate, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, nid, value.c_str());
  X509_add_ext(certificate, extension, -1);
  X509_EXTENSION_free(extension);
}

void add_uris(X509* certificate, const std::vector<std::string>& uris) {
  if (uris.empty()) return;
  GENERAL_NAMES* names = sk_GENERAL_NAME_new_null();
  for (const auto& uri : uris) {
    GENERAL_NAME* name = GENERAL_NAME_new();
    ASN1_IA5STRING* text = ASN1_IA5STRING_new();
    ASN1_STRING_set(text, uri.data(), static_cast<int>(uri.size()));
    GENERAL_NAME_set0_value(name, GEN_URI, text);
    sk_GENERAL_NAME_push(names, name);
  }
  X509_add1_ext_i2d(certificate, NID_subject_alt_name, names, 0, 0);
  GENERAL_NAMES_free(names);
}

Signer make(const Subject& subject, const Signer* authority, const std::string& constraints, const std::string& usage) {
  Signer made;
  made.key.reset(EVP_EC_gen("P-256"));
  made.certificate.reset(X509_new());
  auto* certificate = made.certificate.get();
  X509_set_version(certificate, X509_VERSION_3);
  ASN1_INTEGER_set(X509_get_serialNumber(certificate), subject.serial);
  constexpr long kDay = 86400;
  X509_gmtime_adj(X509_getm_notBefore(certificate), -10 * kDay);
  X509_gmtime_adj(X509_getm_notAfter(certificate), subject.days * kDay);
  X509_set_pubkey(certificate, made.key.get());
  auto* name = X509_get_subject_name(certificate);
  for (const auto& [field, text] : {std::pair("O", subject.organization), std::pair("CN", subject.name)}) {
    X509_NAME_add_entry_by_txt(name, field, MBSTRING_UTF8, reinterpret_cast<const unsigned char*>(text.c_str()), -1, -1,
                               0);
  }
  X509_set_issuer_name(certificate, authority == nullptr ? name : X509_get_subject_name(authority->certificate.get()));
  add_extension(certificate, NID_basic_constraints, constraints);
  add_extension(certificate, NID_key_usage, usage);
  add_extension(certificate, NID_ext_key_usage, subject.purposes);
  add_uris(certificate, subject.uris);
  X509_sign(certificate, authority == nullptr ? made.key.get() : authority->key.get(), EVP_sha256());
  return made;
}

}  // namespace

std::string Signer::key_pem() const {
  BIO* bio = BIO_new(BIO_s_mem());
  PEM_write_bio_PrivateKey(bio, key.get(), nullptr, nullptr, 0, nullptr, nullptr);
  return content_of(bio);
}

std::string Signer::certificate_pem() const {
  BIO* bio = BIO_new(BIO_s_mem());
  PEM_write_bio_X509(bio, certificate.get());
  return content_of(bio);
}

Signer make_authority(const std::string& name, Signs what) {
  const bool documents = what == Signs::Documents;
  const Subject subject{.name = name, .purposes = documents ? "emailProtection" : "", .days = 100};
  if (documents) return make(subject, nullptr, "critical,CA:FALSE", "critical,digitalSignature");
  const std::string usage = "critical,keyCertSign,cRLSign";
  return make(subject, nullptr, "critical,CA:TRUE,pathlen:0",
              what == Signs::Both ? usage + ",digitalSignature" : usage);
}

Signer make_member(const Signer& authority, const Subject& subject) {
  return make(subject, &authority, "critical,CA:FALSE", "critical,digitalSignature");
}

std::string signed_text(const Signer& signer, const std::string& xml) {
  BIO* in = BIO_new_mem_buf(xml.data(), static_cast<int>(xml.size()));
  PKCS7* signature = PKCS7_sign(signer.certificate.get(), signer.key.get(), nullptr, in, PKCS7_TEXT | PKCS7_DETACHED);
  BIO_free(in);
  in = BIO_new_mem_buf(xml.data(), static_cast<int>(xml.size()));
  BIO* out = BIO_new(BIO_s_mem());
  SMIME_write_PKCS7(out, signature, in, PKCS7_TEXT | PKCS7_DETACHED);
  BIO_free(in);
  PKCS7_free(signature);
  return content_of(out);
}

std::string governance_xml() {
  const auto rule = [](const std::string& topic, const std::string& kind) {
    return fmt::format(
        "<topic_rule><topic_expression>{}</topic_expression>"
        "<enable_discovery_protection>true</enable_discovery_protection>"
        "<enable_liveliness_protection>true</enable_liveliness_protection>"
        "<enable_read_access_control>true</enable_read_access_control>"
        "<enable_write_access_control>true</enable_write_access_control>"
        "<metadata_protection_kind>{}</metadata_protection_kind>"
        "<data_protection_kind>NONE</data_protection_kind></topic_rule>",
        topic, kind);
  };
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds><domain_access_rules><domain_rule><domains><id_range><min>0</min><max>230</max></id_range></domains>
<allow_unauthenticated_participants>false</allow_unauthenticated_participants>
<enable_join_access_control>true</enable_join_access_control>
<discovery_protection_kind>ENCRYPT</discovery_protection_kind>
<liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
<rtps_protection_kind>SIGN</rtps_protection_kind>
<topic_access_rules>)" +
         rule("rubicon_frames", "ENCRYPT") + rule("*", "ENCRYPT_WITH_ORIGIN_AUTHENTICATION") +
         "</topic_access_rules></domain_rule></domain_access_rules></dds>\n";
}

std::string permissions_xml(const Subject& subject, const std::string& writes, const std::string& reads) {
  return fmt::format(
      R"(<?xml version="1.0" encoding="UTF-8"?>
<dds><permissions><grant name="{0}"><subject_name>CN={0},O={1}</subject_name>
<validity><not_before>2020-01-01T00:00:00Z</not_before><not_after>2099-01-01T00:00:00Z</not_after></validity>
<allow_rule><domains><id_range><min>0</min><max>230</max></id_range></domains>
<publish><topics><topic>rubicon_frames</topic></topics><partitions><partition>{2}</partition></partitions></publish>
<subscribe><topics><topic>rubicon_frames</topic></topics><partitions><partition>{3}</partition></partitions></subscribe>
</allow_rule><default>DENY</default></grant></permissions></dds>
)",
      subject.name, subject.organization, writes, reads);
}

void Documents::write_to(const std::string& folder) const {
  std::filesystem::create_directories(folder);
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(folder + "/" + name, std::ios::binary) << text;
  };
  write("identity-ca.pem", identity_ca);
  write("certificate.pem", certificate);
  write("key.pem", key);
  write("permissions-ca.pem", permissions_ca);
  write("governance.p7s", governance);
  write("permissions.p7s", permissions);
}

}  // namespace rubicon::trust::guard
