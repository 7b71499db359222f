#include "stereo_selfcal.h"
size_t uart_read(uint8_t *to, size_t room); /* these five are the board's */
size_t flash_read(int page, uint8_t *to, size_t room);
void flash_write(int page, const uint8_t *from, size_t length); /* keeps the old one until done */
void rectifier_load(const selfcal_calibration_t *calibration); /* extrinsics and cameras */
void arming_allow(bool allowed);
enum { FACTORY_PAGE, SNAPSHOT_PAGE, PAIRS_PER_SNAPSHOT = 1000 };
static selfcal_t cal;
static selfcal_link_t wire; /* decodes the frames of core/src/link/FORMAT.md */
static uint8_t record[SELFCAL_SNAPSHOT_BYTES], bytes[64];
static selfcal_factory_t factory;
static selfcal_calibration_t rig;
static void take_pair(void) /* refusals are normal, of bad pairs and before the estimate is locked */
{
    static unsigned fused;
    selfcal_verdict_t verdict;
    if (!selfcal_solve_pair(&cal, NULL) && ++fused % PAIRS_PER_SNAPSHOT == 0)
        if (!selfcal_snapshot(&cal, record)) flash_write(SNAPSHOT_PAGE, record, sizeof record);
    if (selfcal_verdict(&cal, &verdict)) return;
    arming_allow(verdict.may_arm);
    if (verdict.should_apply && !selfcal_apply(&cal, &rig)) rectifier_load(&rig);
}
int main(void) /* returns an error that calls for a restart */
{
    size_t used, length = flash_read(FACTORY_PAGE, record, sizeof record);
    if (selfcal_factory_from_record(&factory, record, length)) return 1;
    if (selfcal_init(&cal, sizeof cal, SELFCAL_HEADER, NULL, &factory) || selfcal_link_init(&wire, sizeof wire)) return 2;
    length = flash_read(SNAPSHOT_PAGE, record, sizeof record);
    if (selfcal_restore(&cal, record, length)) arming_allow(false); /* starts from the factory */
    if (!selfcal_in_use(&cal, &rig)) rectifier_load(&rig); /* from the first image on */
    for (selfcal_frame_t frame;;)
        for (uint8_t *at = bytes, *end = at + uart_read(at, sizeof bytes); at < end; at += used)
        {
            selfcal_error_t error = selfcal_link_feed(&wire, &cal, at, (size_t)(end - at), &used, &frame);
            if (error && error != SELFCAL_ERROR_IMAGE_SIZE) /* a frame of other images is skipped and counted */
                return arming_allow(false), 3;
            if (!error && frame.whole) take_pair();
        }
}
