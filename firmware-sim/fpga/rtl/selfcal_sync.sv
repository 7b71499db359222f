// One bit into another clock domain: two flip-flops, from reset low.
module selfcal_sync (
    input  logic clk,
    input  logic rst,
    input  logic d,
    output logic q
);
    (* ASYNC_REG = "true" *) logic first;
    always_ff @(posedge clk)
        if (rst) {q, first} <= '0;
        else     {q, first} <= {first, d};
endmodule
