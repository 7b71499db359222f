// Bytes to an SPI controller, modes 0 and 3, most significant bit first; `ff` without a byte.
//
// The pins are sampled: SCK at most clk / 8, chip select half a period of SCK before the first edge. A byte
// counts as sent with its eighth rising edge; an interrupted byte is sent again.
module selfcal_spi (
    input  logic        clk,
    input  logic        rst,
    input  logic        valid,
    output logic        ready,
    input  logic [7:0]  data,
    output logic        begun,
    output logic        missed,
    input  logic        sck,
    input  logic        cs_n,
    output logic        miso
);
    logic sck_now, sck_before, selected, rising, falling;
    logic real_byte, armed;
    logic [2:0] bits;
    logic [7:0] shift;

    selfcal_sync sck_sync (.clk(clk), .rst(1'b0), .d(sck),   .q(sck_now));
    selfcal_sync cs_sync  (.clk(clk), .rst(1'b0), .d(!cs_n), .q(selected));

    assign rising  = sck_now && !sck_before;
    assign falling = !sck_now && sck_before;
    assign miso    = shift[7];

    always_ff @(posedge clk) begin
        sck_before <= sck_now;
        {ready, begun, missed} <= '0;
        if (rst) begin
            {bits, real_byte, armed} <= '0;
            shift <= '1;
        end else if (!selected) begin
            // Arms the output between transactions. After a reset within a transaction, the output is idle until the
            // transaction ends.
            armed <= 1'b1;
            bits <= '0;
            real_byte <= valid && !ready;
            shift <= valid && !ready ? data : '1;
        end else if (armed) begin
            if (rising) begin
                bits <= bits + 3'd1;
                begun <= bits == '0 && real_byte;
                missed <= bits == '0 && !real_byte;
                ready <= bits == 3'd7 && real_byte;
            end
            if (falling)
                if (bits == '0) begin
                    real_byte <= valid;
                    shift <= valid ? data : '1;
                end else
                    shift <= {shift[6:0], 1'b1};
        end
    end
endmodule
