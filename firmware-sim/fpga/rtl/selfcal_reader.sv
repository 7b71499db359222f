// Sends the frames of the store as bytes of an AXI4-Stream, with both CRCs.
//
// The first byte of every frame is the same, so the frame is chosen, and kept, only once the sink starts on this byte.
module selfcal_reader #(
    parameter int MATCHES = 254
) (
    input  logic        clk,
    input  logic        rst,

    output logic        m_valid,
    input  logic        m_ready,
    output logic [7:0]  m_data,
    output logic        m_last,
    // The sink has started on the valid byte, and takes it later.
    input  logic        m_begun,
    // The sink went on without a byte: a frame that is not granted yet starts over.
    input  logic        m_missed,
    // A frame waits or is partly read.
    output logic        m_available,

    input  logic                          waiting,
    output logic                          want,
    input  logic                          granted,
    output logic [$clog2(MATCHES+2)-1:0]  r_word,
    input  logic [127:0]                  r_data
);
    localparam int WORD_BITS = $clog2(MATCHES + 2);

    // IDLE offers the first byte of a frame. GRANT waits until the store grants a frame. FETCH waits a cycle for the
    // next word, LOAD loads a byte of it, SEND offers this byte. DONE waits until the store takes its bank back.
    typedef enum logic [2:0] {IDLE, GRANT, FETCH, LOAD, SEND, DONE} state_t;
    state_t state;

    logic        start_over;
    logic [3:0]  at;
    logic [15:0] left;       // records not begun yet
    logic        header_crc; // bytes 28 to 31
    logic        tail;       // the CRC at the end
    logic [31:0] crc, crc_next;

    selfcal_crc32 crc32 (.crc(crc), .data(m_data), .next(crc_next));

    assign header_crc = r_word == WORD_BITS'(1) && at[3:2] == 2'b11;
    assign m_available = state == IDLE ? m_valid || (waiting && !granted) : state != DONE;

    always_ff @(posedge clk)
        if (rst) begin
            {state, want, m_valid, m_last, start_over, tail} <= '0;
            {r_word, at, left, m_data} <= '0;
            crc <= '1;
        end else
            case (state)
                IDLE: begin
                    crc <= '1;
                    {r_word, at, tail, start_over} <= '0;
                    m_data <= 8'h53;
                    // An offered byte stays.
                    if (waiting && !granted) m_valid <= 1'b1;
                    if (m_valid && m_begun) want <= 1'b1;
                    if (m_valid && m_ready) begin
                        m_valid <= 1'b0;
                        want <= 1'b1;
                        at <= 4'd1;
                        crc <= crc_next;
                        state <= granted ? LOAD : GRANT;
                    end
                end
                GRANT: begin
                    if (m_missed) start_over <= 1'b1;
                    if (granted) begin
                        // Two cycles after the change of banks the memory has been read.
                        state <= LOAD;
                        if (start_over || m_missed) begin
                            at <= '0;
                            crc <= '1;
                        end
                    end
                end
                FETCH: state <= LOAD;
                LOAD: begin
                    m_data <= tail || header_crc ? ~crc[{at[1:0], 3'd0} +: 8] : r_data[{at, 3'd0} +: 8];
                    m_valid <= 1'b1;
                    m_last <= tail && at[1:0] == 2'd3;
                    state <= SEND;
                    if (r_word == '0) left <= r_data[111:96];
                end
                SEND:
                    if (m_ready) begin
                        m_valid <= 1'b0;
                        state <= LOAD;
                        at <= at + 4'd1;
                        if (!tail && !header_crc) crc <= crc_next;
                        if (m_last) begin
                            {m_last, want} <= '0;
                            state <= DONE;
                        end else if (at == 4'd15) begin
                            state <= FETCH;
                            r_word <= r_word + WORD_BITS'(1);
                            if (r_word != '0) begin
                                tail <= left == '0;
                                left <= left - 16'd1;
                            end
                        end
                    end
                default: if (!granted) state <= IDLE;
            endcase

`ifdef FORMAL
    // Checked in simulation: a frame ends after the four bytes of its CRC, and an offered byte stays.
    logic settled = 1'b0, held, kept_last;
    logic [1:0] sent; // bytes of the CRC
    logic [7:0] kept;
    wire [31:0] value = ~crc;
    always_ff @(posedge clk) begin
        held <= m_valid && !m_ready && !rst;
        {kept, kept_last} <= {m_data, m_last};
        if (rst) settled <= 1'b1;
        if (!tail) sent <= '0;
        else if (m_valid && m_ready) sent <= sent + 2'd1;
        if (settled) begin
            assert (m_valid == (state == SEND) || (state == IDLE && !m_last));
            assert (!m_last || (state == SEND && tail && sent == 2'd3));
            assert (!tail || state inside {IDLE, DONE} || (at == {2'b00, sent} && state inside {FETCH, LOAD, SEND}));
            assert (!(tail && state == SEND) || m_data == value[{sent, 3'd0} +: 8]);
            assert (state != DONE || (tail && sent == '0 && !m_valid));
            assert (state != IDLE || !m_last);
            assert (!held || (m_valid && m_data == kept && m_last == kept_last));
        end
    end
`endif
endmodule
