/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * See fastdds_peer.h. What is set is what rmw_fastrtps_shared_cpp sets for a discovery range of
 * LOCALHOST (participant.cpp, qos.cpp, publisher.cpp), but for the transport: UDP alone, which is
 * what reaches Cyclone, and on the loopback interface alone; and no time runs out.
 */
#include "fastdds_peer.h"

extern "C" {
#include "dds/ros2/type_hash.h"
}

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

namespace
{
using bytes = std::vector<uint8_t>;
using return_code = eprosima::fastrtps::types::ReturnCode_t;
/* A type whose samples are their encoding. */
class encoded_type : public fast::TopicDataType
{
  public:
    explicit encoded_type(const char *name)
    {
        setName(name);
        m_typeSize = 1024; /* a payload at first; larger samples enlarge it */
        auto_fill_type_object(false);
        auto_fill_type_information(false);
    }
    bool serialize(void *data, rtps::SerializedPayload_t *payload) override
    {
        const bytes &sample = *static_cast<bytes *>(data);
        if (sample.size() > payload->max_size)
            return false;
        std::memcpy(payload->data, sample.data(), sample.size());
        payload->length = static_cast<uint32_t>(sample.size());
        payload->encapsulation = CDR_LE;
        return true;
    }
    bool deserialize(rtps::SerializedPayload_t *payload, void *data) override
    {
        static_cast<bytes *>(data)->assign(payload->data, payload->data + payload->length);
        return true;
    }
    std::function<uint32_t()> getSerializedSizeProvider(void *data) override
    {
        return [data] { return static_cast<uint32_t>(static_cast<bytes *>(data)->size()); };
    }
    void *createData() override
    {
        return new bytes;
    }
    void deleteData(void *data) override
    {
        delete static_cast<bytes *>(data);
    }
    bool getKey(void *, rtps::InstanceHandle_t *, bool) override
    {
        return false;
    }
};

void copy_gid(const rtps::GUID_t &guid, uint8_t gid[16])
{
    std::memcpy(gid, guid.guidPrefix.value, sizeof guid.guidPrefix.value);
    std::memcpy(gid + sizeof guid.guidPrefix.value, guid.entityId.value,
                sizeof guid.entityId.value);
}

template <size_t size> void copy_text(const std::string &text, char (&out)[size])
{
    out[text.copy(out, size - 1)] = '\0';
}

std::array<uint8_t, 16> gid_of(const rtps::GUID_t &guid)
{
    std::array<uint8_t, 16> gid;
    copy_gid(guid, gid.data());
    return gid;
}

template <class ProxyData> fastdds_endpoint describe(const ProxyData &data)
{
    fastdds_endpoint e = {};
    const auto &user_data = data.m_qos.m_userData.data_vec();
    copy_text(data.typeName().to_string(), e.type);
    copy_text(std::string(user_data.begin(), user_data.end()), e.user_data);
    copy_gid(data.guid(), e.gid);
    e.reliable = data.m_qos.m_reliability.kind == fast::RELIABLE_RELIABILITY_QOS;
    e.transient_local = data.m_qos.m_durability.kind == fast::TRANSIENT_LOCAL_DURABILITY_QOS;
    return e;
}

/* User data of other participants; endpoints of others by topic and by whether they write: the last
 * that was announced. */
class discovery : public fast::DomainParticipantListener
{
  public:
    void on_participant_discovery(fast::DomainParticipant *,
                                  rtps::ParticipantDiscoveryInfo &&info) override
    {
        const auto &user_data = info.info.m_userData.data_vec();
        const std::lock_guard<std::mutex> lock(mutex);
        participants[gid_of(info.info.m_guid)].assign(user_data.begin(), user_data.end());
    }
    void on_publisher_discovery(fast::DomainParticipant *self,
                                rtps::WriterDiscoveryInfo &&info) override
    {
        if (info.status == rtps::WriterDiscoveryInfo::DISCOVERED_WRITER)
            add(*self, true, info.info);
    }
    void on_subscriber_discovery(fast::DomainParticipant *self,
                                 rtps::ReaderDiscoveryInfo &&info) override
    {
        if (info.status == rtps::ReaderDiscoveryInfo::DISCOVERED_READER)
            add(*self, false, info.info);
    }
    bool await(const char *topic, bool is_writer, fastdds_endpoint *out, int timeout_ms)
    {
        const auto key = std::make_pair(std::string(topic), is_writer);
        std::unique_lock<std::mutex> lock(mutex);
        if (!changed.wait_for(lock, std::chrono::milliseconds(timeout_ms),
                              [&] { return endpoints.count(key) > 0; }))
            return false;
        *out = endpoints[key];
        return true;
    }
    bool find_user_data(const uint8_t gid[16], char (&text)[128])
    {
        std::array<uint8_t, 16> key;
        std::memcpy(key.data(), gid, key.size());
        const std::lock_guard<std::mutex> lock(mutex);
        if (participants.count(key) == 0)
            return false;
        copy_text(participants[key], text);
        return true;
    }

  private:
    template <class ProxyData>
    void add(const fast::DomainParticipant &self, bool is_writer, const ProxyData &data)
    {
        if (data.guid().guidPrefix == self.guid().guidPrefix)
            return;
        const std::lock_guard<std::mutex> lock(mutex);
        endpoints[std::make_pair(data.topicName().to_string(), is_writer)] = describe(data);
        changed.notify_all();
    }
    std::mutex mutex;
    std::condition_variable changed;
    std::map<std::pair<std::string, bool>, fastdds_endpoint> endpoints;
    std::map<std::array<uint8_t, 16>, std::string> participants;
};

fast::DomainParticipantQos participant_qos()
{
    static const char enclave[] = "enclave=/;";
    fast::DomainParticipantQos qos = fast::PARTICIPANT_QOS_DEFAULT;
    const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    auto &builtin = qos.wire_protocol().builtin;
    rtps::Locator_t localhost;
    qos.name("/");
    qos.user_data().assign(enclave, enclave + sizeof enclave); /* with the NUL, as rmw does */
    udp->interfaceWhiteList.emplace_back("127.0.0.1");
    udp->maxInitialPeersRange = 16; /* participants of a domain that are asked */
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    /* any unicast locator: none would add a multicast one */
    builtin.metatrafficUnicastLocatorList.push_back(rtps::Locator_t());
    rtps::IPLocator::setIPv4(localhost, "127.0.0.1");
    builtin.initialPeersList.push_back(localhost);
    builtin.discovery_config.leaseDuration = eprosima::fastrtps::Duration_t(3600, 0);
    builtin.readerHistoryMemoryPolicy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    builtin.writerHistoryMemoryPolicy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return qos;
}

/* Policies that a writer and a reader have in common. */
template <class Qos> void set_qos(Qos &qos, const char *type, const fastdds_qos &from)
{
    const char *const hash = tfa_ros2_user_data(type);
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.data_sharing().off();
    qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = from.depth;
    qos.durability().kind =
        from.transient_local ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
    qos.reliability().kind =
        from.reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
    qos.reliability().max_blocking_time = eprosima::fastrtps::Duration_t(60, 0);
    if (hash != nullptr)
        qos.user_data().assign(hash, hash + std::strlen(hash));
}

template <class Matched, class Incompatible>
fastdds_matches matches_of(const Matched &matched, const Incompatible &incompatible)
{
    return {matched.current_count, static_cast<int>(incompatible.total_count),
            static_cast<int>(incompatible.last_policy_id)};
}

template <class T> void erase(std::vector<std::unique_ptr<T>> &from, const T *one)
{
    from.erase(std::find_if(from.begin(), from.end(),
                            [one](const std::unique_ptr<T> &x) { return x.get() == one; }));
}

} // namespace

struct fastdds_writer {
    fast::DataWriter *writer;
};

struct fastdds_reader {
    fast::DataReader *reader;
};

struct fastdds_peer {
    discovery listener;
    fast::DomainParticipant *participant = nullptr;
    fast::Publisher *publisher = nullptr;
    fast::Subscriber *subscriber = nullptr;
    std::vector<std::unique_ptr<fastdds_writer>> writers;
    std::vector<std::unique_ptr<fastdds_reader>> readers;

    explicit fastdds_peer(uint32_t domain)
    {
        participant = fast::DomainParticipantFactory::get_instance()->create_participant(
            domain, participant_qos(), &listener, fast::StatusMask::none());
        if (participant == nullptr)
            return;
        publisher = participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT);
        subscriber = participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
    }
    ~fastdds_peer()
    {
        if (participant == nullptr)
            return;
        participant->set_listener(nullptr);
        participant->delete_contained_entities();
        fast::DomainParticipantFactory::get_instance()->delete_participant(participant);
    }
    fastdds_peer(const fastdds_peer &) = delete;
    fastdds_peer &operator=(const fastdds_peer &) = delete;

    /* Writers and readers of a topic share it. */
    fast::Topic *topic(const char *name, const char *type)
    {
        if (fast::TopicDescription *const old = participant->lookup_topicdescription(name))
            return static_cast<fast::Topic *>(old);
        if (participant->find_type(type).empty())
            fast::TypeSupport(new encoded_type(type)).register_type(participant);
        return participant->create_topic(name, type, fast::TOPIC_QOS_DEFAULT);
    }
};

const fastdds_qos fastdds_default = {true, false, 10};
const fastdds_qos fastdds_sensor_data = {false, false, 5};
const fastdds_qos fastdds_latched = {true, true, 1};

fastdds_peer *fastdds_open(uint32_t domain)
{
    std::unique_ptr<fastdds_peer> p(new fastdds_peer(domain));
    return p->publisher != nullptr && p->subscriber != nullptr ? p.release() : nullptr;
}

void fastdds_close(fastdds_peer *p)
{
    delete p;
}

void fastdds_gid(const fastdds_peer *p, uint8_t gid[16])
{
    copy_gid(p->participant->guid(), gid);
}

fastdds_writer *fastdds_open_writer(fastdds_peer *p, const char *topic, const char *type,
                                    const fastdds_qos *qos)
{
    fast::DataWriterQos writer_qos = fast::DATAWRITER_QOS_DEFAULT;
    set_qos(writer_qos, type, *qos);
    writer_qos.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
    writer_qos.representation().m_value.assign(1, fast::XCDR_DATA_REPRESENTATION);
    fast::DataWriter *const writer =
        p->publisher->create_datawriter(p->topic(topic, type), writer_qos);
    if (writer == nullptr)
        return nullptr;
    p->writers.emplace_back(new fastdds_writer{writer});
    return p->writers.back().get();
}

fastdds_reader *fastdds_open_reader(fastdds_peer *p, const char *topic, const char *type,
                                    const fastdds_qos *qos)
{
    fast::DataReaderQos reader_qos = fast::DATAREADER_QOS_DEFAULT;
    set_qos(reader_qos, type, *qos);
    reader_qos.type_consistency().representation.m_value.assign(1, fast::XCDR_DATA_REPRESENTATION);
    fast::DataReader *const reader =
        p->subscriber->create_datareader(p->topic(topic, type), reader_qos);
    if (reader == nullptr)
        return nullptr;
    p->readers.emplace_back(new fastdds_reader{reader});
    return p->readers.back().get();
}

void fastdds_close_writer(fastdds_peer *p, fastdds_writer *w)
{
    p->publisher->delete_datawriter(w->writer);
    erase(p->writers, w);
}

void fastdds_close_reader(fastdds_peer *p, fastdds_reader *r)
{
    p->subscriber->delete_datareader(r->reader);
    erase(p->readers, r);
}

bool fastdds_write(fastdds_writer *w, const uint8_t *byte, size_t size)
{
    bytes sample(byte, byte + size);
    return w->writer->write(&sample);
}

size_t fastdds_take(fastdds_reader *r, uint8_t *byte, size_t capacity, int timeout_ms)
{
    using clock = std::chrono::steady_clock;
    const clock::time_point end = clock::now() + std::chrono::milliseconds(timeout_ms);
    fast::SampleInfo info;
    bytes sample;
    do {
        const std::chrono::duration<double> left = end - clock::now();
        r->reader->wait_for_unread_message(
            eprosima::fastrtps::Duration_t(std::max(left.count(), 0.0)));
        /* disposed instances, as of a writer that is gone, come without a sample */
        while (r->reader->take_next_sample(&sample, &info) == return_code::RETCODE_OK)
            if (info.valid_data) {
                if (sample.size() > capacity)
                    return 0;
                std::memcpy(byte, sample.data(), sample.size());
                return sample.size();
            }
    } while (clock::now() < end);
    return 0;
}

fastdds_matches fastdds_writer_matches(fastdds_writer *w)
{
    fast::PublicationMatchedStatus matched;
    fast::OfferedIncompatibleQosStatus incompatible;
    w->writer->get_publication_matched_status(matched);
    w->writer->get_offered_incompatible_qos_status(incompatible);
    return matches_of(matched, incompatible);
}

fastdds_matches fastdds_reader_matches(fastdds_reader *r)
{
    fast::SubscriptionMatchedStatus matched;
    fast::RequestedIncompatibleQosStatus incompatible;
    r->reader->get_subscription_matched_status(matched);
    r->reader->get_requested_incompatible_qos_status(incompatible);
    return matches_of(matched, incompatible);
}

void fastdds_writer_gid(const fastdds_writer *w, uint8_t gid[16])
{
    copy_gid(w->writer->guid(), gid);
}

void fastdds_reader_gid(const fastdds_reader *r, uint8_t gid[16])
{
    copy_gid(r->reader->guid(), gid);
}

bool fastdds_await_endpoint(fastdds_peer *p, const char *topic, bool is_writer,
                            fastdds_endpoint *out, int timeout_ms)
{
    return p->listener.await(topic, is_writer, out, timeout_ms);
}

bool fastdds_participant_user_data(fastdds_peer *p, const uint8_t gid[16], char text[128])
{
    char found[128];
    if (!p->listener.find_user_data(gid, found))
        return false;
    std::memcpy(text, found, sizeof found);
    return true;
}
